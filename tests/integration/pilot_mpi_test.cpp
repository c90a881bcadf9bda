// MPI tasks of the pilot: where their ranks really run, and how they are stopped.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <optional>
#include <sstream>

#include "common/files.hpp"
#include "pilot/launch/local_launcher.hpp"
#include "pilot/launch/marked.hpp"
#include "pilot/task_list.hpp"

namespace granary::pilot {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

class PilotMpi : public ::testing::Test {
 protected:
  fs::path dir = fs::temp_directory_path() / ("granary_pilot_mpi_" + std::to_string(getpid()));
  Machine machine = *local_machine();
  RealLoop loop;
  std::optional<LocalLauncher> launcher;
  Journal journal = Journal::in_memory();
  std::unique_ptr<Pilot> pilot;

  void SetUp() override {
    fs::create_directories(dir);
    launcher.emplace(loop, machine);
    pilot = *Pilot::open({dir, machine}, loop, *launcher, journal);
  }
  void TearDown() override {
    pilot.reset();
    launcher.reset();
    fs::remove_all(dir);
  }
  /// A program of several ranks, each of which prints the cores it may use.
  TaskSpec ranks(const std::string& name, int count, const std::string& then = "true") const {
    TaskSpec spec;
    spec.name = name;
    spec.command = {"/bin/sh", "-c", "grep Cpus_allowed_list /proc/self/status; " + then};
    spec.ranks = count;
    spec.mpi = true;
    return spec;
  }
  std::string output(const std::string& name) const { return read_text(dir / (name + ".out")).value_or(""); }
  std::vector<std::string> cpus(const std::string& name) const {
    std::vector<std::string> list;
    std::istringstream lines(output(name));
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("Cpus_allowed_list:")) list.push_back(line.substr(line.find('\t') + 1));
    }
    return list;
  }
  static int count_of(const std::string& word, const std::string& text) {
    int count = 0;
    for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; ++at) ++count;
    return count;
  }
  std::string cpu(int core) const { return std::to_string(machine.cpu_of(core)); }
};

TEST_F(PilotMpi, PinsTwoRanksToTheirTwoCores) {
  if (machine.n_cores() < 2) GTEST_SKIP() << "needs two cores";

  const auto summary = run_task_list({ranks("two", 2)}, *pilot, loop);

  ASSERT_TRUE(summary.has_value());
  ASSERT_EQ(summary->finished, 1) << summary->ends.at(0).reason << output("two");
  EXPECT_THAT(cpus("two"), UnorderedElementsAre(cpu(0), cpu(1)));
}

TEST_F(PilotMpi, KeepsTwoMpirunsAtOnceOffEachOthersCores) {
  if (machine.n_cores() < 2) GTEST_SKIP() << "needs two cores";

  const auto summary = run_task_list({ranks("left", 1, "sleep 0.5"), ranks("right", 1, "sleep 0.5")}, *pilot, loop);

  ASSERT_TRUE(summary.has_value());
  ASSERT_EQ(summary->finished, 2) << output("left") << output("right");
  const TaskEnd &left = summary->ends[0], &right = summary->ends[1];
  EXPECT_LT(std::max(left.start, right.start), std::min(left.end, right.end)) << "they ran at the same time";
  EXPECT_THAT(cpus("left"), UnorderedElementsAre(cpu(left.cores.front())));
  EXPECT_THAT(cpus("right"), UnorderedElementsAre(cpu(right.cores.front())));
  EXPECT_NE(left.cores, right.cores);
}

TEST_F(PilotMpi, StopsRanksGracefullyAndLeavesNoneWhenTheyDoNotListen) {
  const int count = std::min(2, machine.n_cores());
  TaskSpec good = ranks("good", count, "trap 'echo bye; exit 0' USR1; echo up; while :; do sleep 0.05; done");
  const TaskId good_id = *pilot->submit(good);
  pilot->on_idle([this] { loop.stop(); });
  std::function<void(std::string, TaskId)> when_up = [&](const std::string& name, TaskId id) {
    if (count_of("up\n", output(name)) == count) return pilot->stop(id, "enough");
    loop.after(0.02, [&when_up, name, id] { when_up(name, id); });
  };
  when_up("good", good_id);
  loop.run();

  EXPECT_EQ(pilot->end(good_id)->state, TaskState::stopped);
  EXPECT_EQ(count_of("bye\n", output("good")), count) << output("good");

  TaskSpec deaf = ranks("deaf", count, "trap '' USR1 TERM; echo up; while :; do sleep 0.05; done");
  deaf.stop.grace = 0.3;
  const TaskId deaf_id = *pilot->submit(deaf);
  when_up("deaf", deaf_id);
  loop.run();

  EXPECT_EQ(pilot->end(deaf_id)->state, TaskState::stopped);
  const std::string run_id = journal.records().at(0).payload.text_or("run_id", "");
  EXPECT_TRUE(marked_processes(run_id + ".1.1").empty());
}

}  // namespace
}  // namespace granary::pilot
