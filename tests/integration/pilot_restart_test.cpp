// A pilot in a process of its own, killed in the middle, resumed, asked and stopped from outside.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <functional>
#include <map>
#include <thread>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "pilot/control/control.hpp"
#include "pilot/control/run_lock.hpp"
#include "pilot/journal/journal.hpp"
#include "pilot/launch/run_program.hpp"

namespace granary::pilot {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const std::string kHost = std::string(GRANARY_BIN_DIR) + "/../tests/pilot_host";

class PilotRestart : public ::testing::Test {
 protected:
  fs::path base = fs::temp_directory_path() / ("granary_restart_" + std::to_string(getpid()));
  // Longer than a socket's address holds.
  fs::path dir = base / std::string(120, 'd');
  fs::path tasks = base / "tasks.json";
  int host = -1;

  void SetUp() override { fs::create_directories(dir); }
  void TearDown() override {
    end_host(SIGKILL);
    fs::remove_all(base);
  }

  void write_tasks(const std::string& text) { std::ofstream(tasks) << text; }
  void start_host() {
    host = fork();
    if (host == 0) {
      if (freopen("/dev/null", "w", stdout) == nullptr || freopen("/dev/null", "w", stderr) == nullptr) _exit(99);
      execl(kHost.c_str(), kHost.c_str(), dir.c_str(), tasks.c_str(), nullptr);
      _exit(98);
    }
  }
  int end_host(int signal) {
    if (host < 0) return -1;
    kill(host, signal);
    int status = 0;
    waitpid(host, &status, 0);
    host = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  /// The summary of a pilot that runs to its end.
  json::Value run_host() {
    const auto output = run_program({kHost, dir.string(), tasks.string()}, "", 60.0);
    EXPECT_TRUE(output.has_value());
    EXPECT_TRUE(output->err.empty()) << output->err;
    return json::parse(output->out, "summary").value_or({});
  }
  std::string text(const std::string& file) const { return read_text(dir / file).value_or(""); }
  static void wait_until(const std::function<bool()>& done) {
    for (int k = 0; k < 1000 && !done(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ASSERT_TRUE(done());
  }
  static bool is_alive(int pid) {
    std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
    std::string id, name, state;
    return (file >> id >> name >> state) && state != "Z";
  }
};

TEST_F(PilotRestart, GoesOnAfterAKillWithoutRunningAnythingFinishedTwice) {
  write_tasks(R"({"tasks": [
    {"name": "first", "command": ["/bin/sh", "-c", "echo ran >> first.log"]},
    {"name": "second", "after": ["first"], "command": ["/bin/sh", "-c",
       "echo $$ > pid.$GRANARY_ATTEMPT; test $GRANARY_ATTEMPT = 2 && exit 0; setsid sleep 300 & exec sleep 300"]},
    {"name": "third", "after": ["second"], "command": ["/bin/sh", "-c", "echo ran >> third.log"]}]})");
  start_host();
  wait_until([&] { return text("pid.1").size() > 1; });
  const int orphan = std::stoi(text("pid.1"));
  end_host(SIGKILL);
  EXPECT_TRUE(is_alive(orphan)) << "nobody has ended it yet";

  const json::Value summary = run_host();

  EXPECT_FALSE(is_alive(orphan));
  EXPECT_EQ(summary.text_or("ended", ""), "finished");
  EXPECT_EQ(text("first.log"), "ran\n");
  EXPECT_EQ(text("third.log"), "ran\n");
  const auto journal = read_journal(dir / "journal.jsonl");
  ASSERT_TRUE(journal.has_value());
  int lost = 0;
  for (const Record& record : journal->records) lost += record.kind == "task.lost";
  EXPECT_EQ(lost, 1);
}

TEST_F(PilotRestart, LosesNothingWhenKilledAtManyMoments) {
  std::string list;
  for (int k = 0; k < 150; ++k) {
    list += (k > 0 ? "," : "") + std::string(R"({"name": "t)") + std::to_string(k) +
            R"(", "command": ["/bin/sh", "-c", "echo $GRANARY_TASK >> all.log"]})";
  }
  write_tasks("{\"tasks\": [" + list + "]}");

  for (int round = 0; round < 5; ++round) {
    start_host();
    std::this_thread::sleep_for(std::chrono::milliseconds(20 + 15 * round));
    end_host(SIGKILL);
  }
  const json::Value summary = run_host();

  EXPECT_EQ(summary.integer_or("finished", 0), 150);
  const auto journal = read_journal(dir / "journal.jsonl");
  ASSERT_TRUE(journal.has_value());
  std::map<int, int> finished;
  for (const Record& record : journal->records) {
    if (record.kind == "task.exit" && record.payload.integer_or("exit_code", -1) == 0)
      ++finished[static_cast<int>(record.payload.integer_or("id", -1))];
  }
  EXPECT_EQ(finished.size(), 150u);
  for (const auto& [id, times] : finished) EXPECT_EQ(times, 1) << "task " << id;
}

TEST_F(PilotRestart, KilledAroundAnyStartLosesNoTaskRunsNoneTwiceAndLeavesNoProcess) {
  constexpr int kTasks = 8;
  std::string list;
  for (int k = 0; k < kTasks; ++k) {
    list += (k > 0 ? "," : "") + std::string(R"({"name": "t)") + std::to_string(k) +
            R"(", "command": ["/bin/sh", "-c", "echo $$ >> pids; exec sleep 0.03"]})";
  }
  // Would go on for ever: its orphans must be ended.
  list += R"(, {"name": "long", "priority": 1, "command": ["/bin/sh", "-c",
              "echo $$ >> pids; test $GRANARY_ATTEMPT -gt 8 || exec sleep 300"]})";
  write_tasks("{\"tasks\": [" + list + "]}");

  for (const char* when :
       {"before:1", "after:1", "before:2", "after:2", "before:3", "after:3", "after:4", "before:5"}) {
    setenv("PILOT_HOST_DIE", when, 1);
    start_host();
    int status = 0;
    waitpid(host, &status, 0);
    host = -1;
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << when;
  }
  unsetenv("PILOT_HOST_DIE");
  // It has gone through eight attempts by now, unless it was killed before its start.
  const json::Value summary = run_host();

  EXPECT_EQ(summary.integer_or("finished", 0), kTasks + 1);
  const auto journal = read_journal(dir / "journal.jsonl");
  ASSERT_TRUE(journal.has_value());
  std::map<std::int64_t, int> finished;
  for (const Record& record : journal->records) {
    const std::int64_t id = record.payload.integer_or("id", -1);
    if (record.kind == "task.place") {
      EXPECT_EQ(finished[id], 0) << "task " << id << " ran again";
    }
    finished[id] += record.kind == "task.exit" && record.payload.integer_or("exit_code", -1) == 0;
  }
  for (int id = 0; id <= kTasks; ++id) EXPECT_EQ(finished[id], 1) << "task " << id;
  std::ifstream pids(dir / "pids");
  int n = 0;
  for (int pid = 0; pids >> pid; ++n) EXPECT_FALSE(is_alive(pid)) << pid;
  EXPECT_GE(n, kTasks + 1);
}

TEST_F(PilotRestart, AnswersAndStopsThroughItsSocket) {
  write_tasks(
      R"({"tasks": [{"name": "long", "command": ["sleep", "300"]}, {"name": "next", "after": ["long"], "command": ["true"]}]})");
  start_host();
  wait_until([&] {
    return fs::exists(dir / "control.sock") && ask_pilot(dir, json::Value::object({{"ask", "status"}})).has_value();
  });
  wait_until([&] {
    return (*ask_pilot(dir, json::Value::object({{"ask", "status"}})))["counts"].integer_or("running", 0) == 1;
  });

  struct stat status = {};
  ASSERT_EQ(stat((dir / "control.sock").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  EXPECT_TRUE(pilot_is_alive(dir));
  const auto why = ask_pilot(dir, json::Value::object({{"ask", "explain"}, {"task", "next"}}));
  ASSERT_TRUE(why.has_value());
  EXPECT_THAT(why->text_or("text", ""), HasSubstr("waits for \"long\" (running)"));
  EXPECT_THAT(ask_pilot(dir, json::Value::object({{"ask", "dance"}})).error().message, HasSubstr("cannot \"dance\""));
  EXPECT_FALSE(ask_pilot(dir, json::Value::object({{"ask", std::string(kLargestMessage, 'x')}})).has_value());
  EXPECT_TRUE(ask_pilot(dir, json::Value::object({{"ask", "status"}})).has_value()) << "it is still there";
  const auto second = run_program({kHost, dir.string(), tasks.string()}, "", 10.0);
  EXPECT_EQ(second->exit_code, 2);
  EXPECT_THAT(second->err, HasSubstr("a pilot is running on this folder (process " + std::to_string(host) + ")"));
  ASSERT_TRUE(ask_pilot(dir, json::Value::object({{"ask", "stop"}, {"reason", "test"}})).has_value());
  int code = 0;
  waitpid(host, &code, 0);
  host = -1;

  EXPECT_EQ(WEXITSTATUS(code), 4);
  EXPECT_FALSE(pilot_is_alive(dir));
  EXPECT_THAT(ask_pilot(dir, json::Value::object({{"ask", "status"}})).error().message,
              HasSubstr("no pilot is running on this folder"));
}

TEST_F(PilotRestart, SeesThatAKilledPilotsSocketIsDead) {
  write_tasks(R"({"tasks": [{"name": "long", "command": ["sleep", "2"]}]})");
  start_host();
  wait_until([&] { return ask_pilot(dir, json::Value::object({{"ask", "status"}})).has_value(); });
  end_host(SIGKILL);

  EXPECT_TRUE(RunLock::take(dir).has_value());
  EXPECT_TRUE(fs::exists(dir / "control.sock"));
  // A process that was being made for the next task holds the socket until it has closed its files.
  wait_until([&] { return !pilot_is_alive(dir); });
  EXPECT_THAT(ask_pilot(dir, json::Value::object({{"ask", "status"}})).error().message,
              HasSubstr("no pilot is running"));
}

TEST_F(PilotRestart, EndsResumableOnASignalOfTheUser) {
  write_tasks(
      R"({"tasks": [{"name": "a", "command": ["/bin/sh", "-c", "test $GRANARY_ATTEMPT = 2 || exec sleep 300"]}]})");
  start_host();
  wait_until([&] { return text("journal.jsonl").find("task.start\"") != std::string::npos; });

  EXPECT_EQ(end_host(SIGTERM), 4);
  const json::Value summary = run_host();

  EXPECT_EQ(summary.text_or("ended", ""), "finished");
}

TEST_F(PilotRestart, EndsResumableWhenTheDiskIsFullAndLosesNothingThatFinished) {
  if (mount("none", dir.c_str(), "tmpfs", 0, "size=600k") != 0) GTEST_SKIP() << "may not mount a small file system";
  std::string list;
  for (int k = 0; k < 900; ++k)
    list += (k > 0 ? "," : "") + std::string(R"({"name": "t)") + std::to_string(k) +
            R"(", "command": ["true"], "stdout": "/dev/null"})";
  write_tasks("{\"tasks\": [" + list + "]}");
  const auto full = run_program({kHost, dir.string(), tasks.string()}, "", 60.0);
  EXPECT_EQ(full->exit_code, 4) << full->err;
  EXPECT_THAT(full->err, HasSubstr("the disk is full"));
  const auto before = read_journal(dir / "journal.jsonl");
  ASSERT_TRUE(before.has_value());
  EXPECT_EQ(before->dropped_bytes, 0u);
  int placed = 0, exited = 0;
  for (const Record& record : before->records) {
    placed += record.kind == "task.place";
    exited += record.kind == "task.exit";
  }
  EXPECT_GT(exited, 0);
  EXPECT_EQ(placed, exited) << "what ran when the disk was full has its end in the journal";

  ASSERT_EQ(mount("none", dir.c_str(), "tmpfs", MS_REMOUNT, "size=20m"), 0);
  const json::Value summary = run_host();
  EXPECT_EQ(summary.integer_or("finished", 0), 900);
  umount(dir.c_str());
}

}  // namespace
}  // namespace granary::pilot
