// granary-monitor as the controller runs it: beside a growing file, ended by a verdict, a signal or its program's end.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "common/json/io.hpp"
#include "tests/unit/controller/monitor_lines.hpp"

namespace granary::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;

struct Ended {
  int exit_code = -1;
  std::string out, err;
  double cpu = 0.0;  ///< [s]
};

std::string slurp(const fs::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

class MonitorProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ =
        fs::temp_directory_path() / ("granary_monitor_" + std::string(info->name()) + "_" + std::to_string(::getpid()));
    fs::create_directories(folder_ / "burst");
  }
  void TearDown() override {
    if (child_ > 0) end(SIGKILL);
    fs::remove_all(folder_);
  }

  fs::path burst() const { return folder_ / "burst"; }
  fs::path tallies() const { return burst() / "tallies.jsonl"; }

  void start(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), GRANARY_BIN_DIR "/granary-monitor");
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    child_ = ::fork();
    if (child_ != 0) return;
    for (const auto& [name, fd] : {std::pair{"out", STDOUT_FILENO}, {"err", STDERR_FILENO}})
      ::dup2(::open((folder_ / name).c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644), fd);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }

  /// Waits for its end; after `patience` it is killed and the exit code is -1.
  Ended wait(std::chrono::milliseconds patience = 10s) {
    const auto until = std::chrono::steady_clock::now() + patience;
    int status = 0;
    rusage used{};
    while (::wait4(child_, &status, WNOHANG, &used) == 0) {
      if (std::chrono::steady_clock::now() > until) return end(SIGKILL);
      std::this_thread::sleep_for(5ms);
    }
    child_ = -1;
    const auto seconds = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(folder_ / "out"), slurp(folder_ / "err"),
            seconds(used.ru_utime) + seconds(used.ru_stime)};
  }

  Ended end(int signal) {
    ::kill(child_, signal);
    return wait();
  }

  bool running() const { return ::waitpid(child_, nullptr, WNOHANG) == 0; }

  void write(const json::Value& line) {
    auto writer = json::LineWriter::append_to(tallies());
    ASSERT_TRUE(writer && writer->append(line));
  }

  /// Windows `first` to `last` with so many collisions each.
  void write_windows(int first, int last, double collisions) {
    for (int w = first; w <= last; ++w) {
      TallyLine line;
      line.time = 0.01 * (w + 1);
      line.collisions = collisions;
      write(line.json());
    }
  }

  fs::path folder_;
  pid_t child_ = -1;
};

// Nobody looks by the clock in these tests: with an hour between looks only the kernel's notices wake the monitor.
const std::vector<std::string> kByNoticeOnly{"--grace", "0", "--look-every", "3600"};

std::vector<std::string> watch_dem(const fs::path& burst) {
  std::vector<std::string> arguments{"dem", burst.string()};
  arguments.insert(arguments.end(), kByNoticeOnly.begin(), kByNoticeOnly.end());
  return arguments;
}

TEST_F(MonitorProgram, WaitsForTheFileAndEndsWithTenWhenItDrifts) {
  start(watch_dem(burst()));
  std::this_thread::sleep_for(100ms);
  write(a_tally_header());
  write_windows(0, 9, 1000.0);
  std::this_thread::sleep_for(100ms);
  ASSERT_TRUE(running()) << "nothing has moved yet";
  write_windows(10, 13, 1500.0);

  const Ended ended = wait(2s);

  EXPECT_EQ(10, ended.exit_code) << ended.err;
  const auto verdict = json::parse(ended.out, "stdout");
  ASSERT_TRUE(verdict) << ended.out;
  EXPECT_EQ("drifted", (*verdict)["verdict"].as_string());
  EXPECT_EQ("collisions_per_particle_s", (*verdict)["watched"].as_string());
  EXPECT_EQ(1, std::count(ended.out.begin(), ended.out.end(), '\n')) << "one line";
}

TEST_F(MonitorProgram, EndsWithElevenTwelveAndTwentyToo) {
  write(a_tally_header());
  write_windows(0, 99, 5000.0);
  start({"dem", burst().string(), "--grace", "0", "--steady-window", "0.5"});
  EXPECT_EQ(11, wait().exit_code);
  start({"dem", burst().string(), "--grace", "0", "--converged-tolerance", "0.05"});
  EXPECT_EQ(12, wait().exit_code);
  write(json::Value::object({{"diverged", json::Value::object({{"cause", "energy"}, {"message", "too much"}})}}));
  start({"dem", burst().string(), "--grace", "0"});
  EXPECT_EQ(20, wait().exit_code);
}

TEST_F(MonitorProgram, SaysEndedAtSigterm) {
  write(a_tally_header());
  write_windows(0, 4, 1000.0);
  start(watch_dem(burst()));
  std::this_thread::sleep_for(100ms);

  const Ended ended = end(SIGTERM);

  EXPECT_EQ(0, ended.exit_code);
  EXPECT_THAT(ended.out, HasSubstr(R"("verdict":"ended")"));
}

TEST_F(MonitorProgram, ReadsToTheEndBeforeItObeysSigterm) {
  start({"dem", burst().string(), "--grace", "0", "--look-every", "3600"});
  std::this_thread::sleep_for(100ms);
  ::kill(child_, SIGSTOP);  // the program is faster than its monitor
  write(a_tally_header());
  write_windows(0, 9, 1000.0);
  write_windows(10, 19, 2000.0);
  ::kill(child_, SIGTERM);
  ::kill(child_, SIGCONT);

  EXPECT_EQ(10, wait().exit_code);
}

TEST_F(MonitorProgram, EndsWithItsProgram) {
  write(a_tally_header());
  const pid_t program = ::fork();
  if (program == 0) {
    ::pause();
    ::_exit(0);
  }
  std::vector<std::string> arguments = watch_dem(burst());
  arguments.insert(arguments.end(), {"--pid", std::to_string(program)});
  start(arguments);
  std::this_thread::sleep_for(100ms);
  ASSERT_TRUE(running());

  ::kill(program, SIGKILL);
  const Ended ended = wait(2s);
  ::waitpid(program, nullptr, 0);

  EXPECT_EQ(0, ended.exit_code) << ended.err;
}

TEST_F(MonitorProgram, TakesNextToNoCpu) {
  write(a_tally_header());
  start({"dem", burst().string(), "--grace", "0", "--look-every", "0.05"});
  for (int w = 0; w < 100; ++w) {
    write_windows(w, w, 1000.0);
    std::this_thread::sleep_for(10ms);
  }
  const Ended followed = end(SIGTERM);
  start({"dem", burst().string(), "--grace", "0", "--finished"});
  const Ended read_at_once = wait();

  EXPECT_EQ(0, followed.exit_code) << followed.err;
  EXPECT_LT(followed.cpu - read_at_once.cpu, 0.1) << "for a second of waiting, a hundred lines and twenty looks";
}

TEST_F(MonitorProgram, RefusesAMissingFolder) {
  start({"dem", (folder_ / "nowhere").string()});
  const Ended ended = wait();

  EXPECT_EQ(2, ended.exit_code);
  EXPECT_THAT(ended.err, AllOf(HasSubstr("nowhere"), HasSubstr("no such folder")));
  EXPECT_EQ("", ended.out);
}

TEST_F(MonitorProgram, NamesTheLineThatWasCutShort) {
  write(a_tally_header());
  write_windows(0, 2, 1000.0);
  std::ofstream(tallies(), std::ios::app) << R"({"time_s": 0.04, "step": 40)";
  start({"dem", burst().string(), "--finished"});
  const Ended ended = wait();

  EXPECT_EQ(2, ended.exit_code);
  EXPECT_THAT(ended.err,
              AllOf(HasSubstr("tallies.jsonl"), HasSubstr("number 5, is cut short"), HasSubstr("run the burst again")));
}

TEST_F(MonitorProgram, NamesTheLineThatIsNotJson) {
  write(a_tally_header());
  std::ofstream(tallies(), std::ios::app) << "{\"time_s\": 0.04, \"st\n";
  start(watch_dem(burst()));
  const Ended ended = wait();

  EXPECT_EQ(2, ended.exit_code);
  EXPECT_THAT(ended.err, AllOf(HasSubstr("tallies.jsonl"), HasSubstr("line 2")));
}

TEST_F(MonitorProgram, RefusesUnknownOptionsWithTwo) {
  start({"dem", burst().string(), "--treshold", "0.1"});
  EXPECT_EQ(2, wait().exit_code);
}

}  // namespace
}  // namespace granary::test
