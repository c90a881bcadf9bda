// The crew with a model in place of granary-pbm: no processes. What it submits, what it remembers, what it survives.
#include "controller/estimation/crew.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <deque>
#include <fstream>

#include "common/files.hpp"
#include "common/json/io.hpp"

namespace granary::estimating {
namespace {

namespace fs = std::filesystem;
using estimation::Phase;
using estimation::Problem;
using json::Value;

std::vector<double> model(const std::vector<double>& p) {
  std::vector<double> y;
  for (int t = 0; t < 12; ++t) y.push_back(p[0] * std::exp(-p[1] * t));
  return y;
}

/// Data of a = 2, k = `k`, with an error of 5 % that alternates.
Problem decay(double k) {
  Problem p;
  p.parameters = {{"a", "/a", 0.01, 100.0, estimation::Scale::log, {}, {}},
                  {"k", "/k", 1e-3, 1.0, estimation::Scale::log, {}, {}}};
  p.experiments = {{"one", {Value::object({{"a", 1.0}, {"k", 1.0}})}}};
  double sign = 1.0;
  for (const double y : model({2.0, k})) {
    estimation::Target t;
    t.experiment = "one";
    t.value = y * (1.0 + 0.05 * (sign = -sign));
    t.error = 0.05 * y;
    p.targets.push_back(t);
  }
  return p;
}

class CrewTest : public testing::Test {
 protected:
  CrewTest() : dir(fs::temp_directory_path() / ("granary-crew-" + std::to_string(::getpid()))) { fs::remove_all(dir); }
  ~CrewTest() override { fs::remove_all(dir); }

  Crew crew(bool until_done = true) {
    CrewSettings settings;
    settings.dir = dir;
    settings.program = "granary-pbm";
    settings.cores = 2;
    settings.until_done = until_done;
    return Crew(settings);
  }

  /// What granary-pbm evaluate would do for such a task; only the first `most` trials.
  void run(const pilot::TaskSpec& task, std::size_t most = 1000000) const {
    const auto document = json::read_file(dir / task.command[2]);
    const auto problem = estimation::read_problem(*document, "problem");
    const auto trials = json::read_file(dir / task.command[3]);
    auto out = json::LineWriter::create(dir / task.command[5]);
    for (const Value& trial : (*trials)["trials"].items()) {
      if (most-- == 0) return;
      const std::vector<double> values = trial.numbers("values"), computed = model(values);
      const auto fit = estimation::fit_of(*problem, computed, values);
      ASSERT_TRUE(out->append(Value::object({{"trial", trial["number"].as_integer()},
                                             {"residuals", fit.residuals},
                                             {"held_out", fit.held_out},
                                             {"model", computed},
                                             {"seconds", 0.02}}))
                      .has_value());
    }
  }

  static pilot::TaskEnd end_of(const pilot::TaskSpec& task, pilot::TaskState state = pilot::TaskState::finished,
                               int exit_code = 0) {
    pilot::TaskEnd end;
    end.name = task.name;
    end.state = state;
    end.exit_code = exit_code;
    return end;
  }

  static void add(std::deque<pilot::TaskSpec>& queue, Crew& crew) {
    auto tasks = crew.next();
    ASSERT_TRUE(tasks.has_value()) << tasks.error().message;
    for (const pilot::TaskSpec& task : *tasks) queue.push_back(task);
  }

  /// Runs tasks in order until the crew is done, or so many have ended.
  int work(Crew& crew, std::deque<pilot::TaskSpec>& queue, int most = 100000) {
    int n = 0;
    for (; n < most && !crew.done(); ++n) {
      add(queue, crew);
      if (queue.empty()) break;
      run(queue.front());
      const Status taken = crew.ended(end_of(queue.front()));
      EXPECT_TRUE(taken.has_value()) << taken.error().message;
      queue.pop_front();
    }
    return n;
  }

  std::string log() const { return read_text(dir / "estimation" / "evaluations.jsonl").value_or(""); }

  fs::path dir;
};

TEST_F(CrewTest, FindsTheParametersWithFillersAndLeavesNoFilesOfBatches) {
  Crew c = crew();
  ASSERT_TRUE(c.begin(decay(0.1)).has_value());
  std::deque<pilot::TaskSpec> queue;
  add(queue, c);
  ASSERT_EQ(queue.size(), 3u);  // two cores, and one that waits
  EXPECT_TRUE(queue[0].fill);
  EXPECT_EQ(queue[0].preempt, pilot::Preempt::suspend);
  EXPECT_EQ(queue[0].cores(), 1);
  work(c, queue);
  EXPECT_TRUE(c.done());
  EXPECT_NEAR(c.best()->values[0], 2.0, 0.2);
  EXPECT_NEAR(c.best()->values[1], 0.1, 0.02);
  const auto best = json::read_file(dir / "estimation" / "best.json");
  ASSERT_TRUE(best.has_value());
  EXPECT_EQ((*best)["phase"].as_string(), "done");
  EXPECT_EQ((*best)["parameters"].items()[1]["value"].as_number(), c.best()->values[1]);
  // Those that still waited when it was done.
  const auto left = std::distance(fs::directory_iterator(dir / "estimation" / "batches"), fs::directory_iterator());
  EXPECT_LE(left, 3);
}

TEST_F(CrewTest, GoesOnAfterAKillWithTheTrialsItWouldHaveAskedFor) {
  std::string uninterrupted;
  {
    Crew c = crew();
    ASSERT_TRUE(c.begin(decay(0.1)).has_value());
    std::deque<pilot::TaskSpec> queue;
    work(c, queue, 40);
    uninterrupted = log();
  }
  fs::remove_all(dir);

  std::deque<pilot::TaskSpec> lost;
  {
    Crew c = crew();
    ASSERT_TRUE(c.begin(decay(0.1)).has_value());
    work(c, lost, 17);
  }
  {  // a write that did not end
    std::ofstream torn(dir / "estimation" / "evaluations.jsonl", std::ios::app);
    torn << "{\"version\":1,\"tri";
  }
  Crew c = crew();
  const Status begun = c.begin(decay(0.1));
  ASSERT_TRUE(begun.has_value()) << begun.error().message;
  std::deque<pilot::TaskSpec> queue;
  add(queue, c);
  ASSERT_EQ(queue.size(), 3u);
  EXPECT_EQ(queue[0].name, lost[0].name);  // the pilot may know it
  work(c, queue, 23);
  EXPECT_EQ(log(), uninterrupted);
}

TEST_F(CrewTest, CountsWhatABatchLostAndGoesOn) {
  Crew c = crew();
  ASSERT_TRUE(c.begin(decay(0.1)).has_value());
  std::deque<pilot::TaskSpec> queue;
  work(c, queue, 6);
  add(queue, c);
  run(queue.back(), 2);
  ASSERT_TRUE(c.ended(end_of(queue.back(), pilot::TaskState::failed, -1)).has_value());
  EXPECT_GT(c.estimator().failed(), 0);
  queue.pop_back();
  work(c, queue);
  EXPECT_TRUE(c.done());
}

TEST_F(CrewTest, NewRatesMakeOldTasksStaleAndAreRememberedByAResume) {
  Crew c = crew();
  ASSERT_TRUE(c.begin(decay(0.1)).has_value());
  std::deque<pilot::TaskSpec> queue;
  work(c, queue, 30);
  add(queue, c);
  const auto stale = c.change(decay(0.2));
  ASSERT_TRUE(stale.has_value());
  EXPECT_EQ(stale->size(), 3u);
  EXPECT_EQ(c.version(), 2);
  run(queue.front());
  ASSERT_TRUE(c.ended(end_of(queue.front())).has_value());  // late
  EXPECT_FALSE(c.best().has_value());
  queue.clear();
  work(c, queue, 20);

  Crew again = crew();
  ASSERT_TRUE(again.begin(decay(0.2)).has_value());
  EXPECT_EQ(again.version(), 2);
  EXPECT_EQ(again.best()->values, c.best()->values);
  queue.clear();
  work(again, queue);
  EXPECT_NEAR(again.best()->values[1], 0.2, 0.03);
}

TEST_F(CrewTest, StopsWhenTheProgramRefusesTheProblemAndSaysWhatItSaid) {
  Crew c = crew();
  ASSERT_TRUE(c.begin(decay(0.1)).has_value());
  std::deque<pilot::TaskSpec> queue;
  add(queue, c);
  ASSERT_TRUE(write_text_atomically(dir / queue[0].stdout_file, "granary-pbm: no such key\n").has_value());
  const Status taken = c.ended(end_of(queue[0], pilot::TaskState::failed, 2));
  ASSERT_FALSE(taken.has_value());
  EXPECT_THAT(taken.error().message, testing::HasSubstr("no such key"));
}

TEST_F(CrewTest, SamplesOnWhileCoresIdleUnlessItIsToEnd) {
  Crew c = crew(false);
  ASSERT_TRUE(c.begin(decay(0.1)).has_value());
  std::deque<pilot::TaskSpec> queue;
  while (c.begun() && c.estimator().phase() != Phase::done) ASSERT_EQ(work(c, queue, 1), 1);
  EXPECT_EQ(work(c, queue, 5), 5);
  EXPECT_FALSE(c.done());
}

TEST_F(CrewTest, AFileThatIsNoLogIsAnErrorWithItsLine) {
  ASSERT_TRUE(make_folders(dir / "estimation").has_value());
  ASSERT_TRUE(write_text_atomically(dir / "estimation" / "evaluations.jsonl", "{\"batch\": 1}\n").has_value());
  Crew c = crew();
  const Status begun = c.begin(decay(0.1));
  ASSERT_FALSE(begun.has_value());
  EXPECT_THAT(begun.error().message, testing::HasSubstr("line 1"));
}

}  // namespace
}  // namespace granary::estimating
