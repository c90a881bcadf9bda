// Campaigns on virtual nodes: agents on this machine, started, killed and lied to.
#include <gmock/gmock.h>
#include <sys/wait.h>

#include "tests/support/agent_tasks.hpp"
#include "tests/support/granary_program.hpp"

namespace granary::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Agents : public ::testing::Test {
 protected:
  void TearDown() override {
    if (pid > 0) end(SIGKILL);
    if (scratch && HasFailure()) std::printf("%s\n", text_in(*scratch / "err").c_str());
  }

  fs::path dir() const { return *scratch / "run"; }

  void write(json::Value tasks) {
    scratch.emplace();
    write_workflow(*scratch / "w.json", "w", json::Value::object(), std::move(tasks));
  }
  /// The pilot in the background, on virtual nodes of one core.
  void start(int nodes) {
    const std::string program = (kPrograms / "granary").string(), n = std::to_string(nodes);
    const std::string workflow = (*scratch / "w.json").string(), folder = dir().string();
    const bool begun = fs::exists(dir() / "journal.jsonl");
    pid = fork();
    if (pid > 0) return;
    if (freopen((*scratch / "out").c_str(), "a", stdout) == nullptr) _exit(99);
    if (freopen((*scratch / "err").c_str(), "a", stderr) == nullptr) _exit(99);
    if (begun) {
      execl(program.c_str(), program.c_str(), "resume", folder.c_str(), "-q", "--virtual-nodes", n.c_str(), nullptr);
    } else {
      execl(program.c_str(), program.c_str(), "run", workflow.c_str(), "--dir", folder.c_str(), "-q", "--virtual-nodes",
            n.c_str(), "--cores", "1", nullptr);
    }
    _exit(98);
  }
  int end(int signal = 0) {
    if (signal != 0) kill(pid, signal);
    int status = 0;
    waitpid(pid, &status, 0);
    pid = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  int done() const {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(dir()))
      if (entry.path().extension() == ".log") count += count_in(text_in(entry.path()), "done") > 0 ? 1 : 0;
    return count;
  }
  void wait_for_done(int count) {
    ASSERT_TRUE(wait_until([&] { return fs::exists(dir() / "journal.jsonl") && done() >= count; }, 20.0)) << done();
  }

  std::optional<Scratch> scratch;
  int pid = -1;
};

TEST_F(Agents, RunTasksOnTheirNodesAndTellWhyOneCannotStart) {
  json::Value tasks = honest_tasks(6, 0.1);
  tasks.push(json::Value::object({{"name", "missing"}, {"command", std::vector<std::string>{"no-such-program"}}}));
  tasks.push(json::Value::object({{"name", "light"}, {"light", true}, {"command", std::vector<std::string>{"true"}}}));
  tasks.push(json::Value::object({{"name", "promise"},
                                  {"command", std::vector<std::string>{"true"}},
                                  {"produces", std::vector<std::string>{"nothing.dat"}}}));
  tasks.push(json::Value::object({{"name", "env"},
                                  {"command", std::vector<std::string>{"env"}},
                                  {"env", json::Value::object({{"MINE", "yes"}})}}));
  write(tasks);
  start(3);

  EXPECT_EQ(end(), 3);
  expect_each_finished_once(dir(), 6);
  const json::Value status = granary_json({"status", dir().string(), "--json"});
  EXPECT_EQ(status["counts"].integer_or("finished", 0), 8);
  EXPECT_EQ(status["counts"].integer_or("failed", 0), 2);
  const std::string err = text_in(*scratch / "err");
  EXPECT_THAT(err, HasSubstr("missing: no-such-program: no such program in PATH"));
  EXPECT_THAT(err, HasSubstr("promise: ended with exit code 0, but did not produce nothing.dat"));
  const std::string env = text_in(dir() / "env.out");
  EXPECT_THAT(env, HasSubstr("MINE=yes\n"));
  EXPECT_THAT(env, HasSubstr("GRANARY_AGENT="));
  EXPECT_THAT(env, Not(HasSubstr(text_in(dir() / "secret"))));
  EXPECT_EQ(agent_of(dir(), "node1").guardian, 0) << "agents end with their pilot";
  EXPECT_FALSE(fs::exists(dir() / "endpoint.json"));
}

TEST_F(Agents, AreStartedAnewWhenTheyDieAndEndWhatTheyLeft) {
  write(honest_tasks(18, 0.5));
  start(3);
  wait_for_done(3);
  kill(agent_of(dir(), "node1").worker, SIGKILL);
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  const AgentPids both = agent_of(dir(), "node2");
  kill(both.guardian, SIGKILL);
  kill(both.worker, SIGKILL);
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  kill(agent_of(dir(), "node3").guardian, SIGKILL);

  EXPECT_EQ(end(), 0);
  expect_each_finished_once(dir(), 18);
  EXPECT_EQ(times_of(dir(), "node.lost").size(), 3u);
  EXPECT_EQ(times_of(dir(), "node.back").size(), 3u);
  EXPECT_LE(times_of(dir(), "task.lost").size(), 3u);
  EXPECT_EQ(processes_of_tasks(dir()), 0);
}

TEST_F(Agents, ThatAreStoppedGoOnWithinASecondAndNothingIsLost) {
  write(honest_tasks(12, 0.3));
  start(2);
  wait_for_done(2);
  for (int round = 0; round < 3; ++round) {
    kill(agent_of(dir(), "node1").worker, SIGSTOP);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  }

  EXPECT_EQ(end(), 0);
  expect_each_finished_once(dir(), 12);
  EXPECT_TRUE(times_of(dir(), "node.lost").empty());
  EXPECT_TRUE(times_of(dir(), "task.lost").empty());
}

TEST_F(Agents, EndTheirTasksWhenThePilotIsKilledAndTheNextPilotGoesOn) {
  write(honest_tasks(15, 0.4));
  start(3);
  wait_for_done(3);
  end(SIGKILL);
  EXPECT_TRUE(wait_until([&] { return processes_of_tasks(dir()) == 0; }, 3.0)) << "tasks live without a pilot";
  EXPECT_TRUE(wait_until([&] { return agent_of(dir(), "node2").guardian == 0; }, 5.0));
  start(3);

  EXPECT_EQ(end(), 0);
  expect_each_finished_once(dir(), 15);
}

TEST_F(Agents, OfAKilledPilotDoNotMeddleWithTheNextOne) {
  write(honest_tasks(12, 0.4));
  for (int round = 0; round < 3; ++round) {
    start(3);
    ASSERT_TRUE(wait_until([&] { return fs::exists(dir() / "endpoint.json"); }, 10.0));
    std::this_thread::sleep_for(std::chrono::milliseconds(100 + 150 * round));
    end(SIGKILL);
  }
  start(3);  // while agents of three pilots may still be there

  EXPECT_EQ(end(), 0);
  expect_each_finished_once(dir(), 12);
}

TEST_F(Agents, RaiseNoFalseAlarmUnderLoad) {
  json::Value tasks = json::Value::array();
  for (int k = 0; k < 3; ++k) tasks.push(honest_task("t" + std::to_string(k), 5.0));
  write(tasks);
  std::vector<int> spinning;
  for (int k = 0; k < 24; ++k) {
    const int child = fork();
    if (child == 0)
      for (;;) continue;
    spinning.push_back(child);
  }
  start(3);
  const int code = end();
  for (const int child : spinning) {
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
  }

  EXPECT_EQ(code, 0);
  EXPECT_TRUE(times_of(dir(), "node.lost").empty());
  expect_each_finished_once(dir(), 3);
}

TEST_F(Agents, OfASilentNodeAreMissedWithinFiveSecondsAndTakenAgainWhenItSpeaks) {
  json::Value tasks = json::Value::array();
  for (int k = 0; k < 9; ++k)
    tasks.push(
        json::Value::object({{"name", "t" + std::to_string(k)}, {"command", std::vector<std::string>{"sleep", "2"}}}));
  write(tasks);
  start(3);
  ASSERT_TRUE(wait_until([&] { return fs::exists(dir() / "t2.out"); }, 10.0));
  // The whole node freezes; its connections stay open.
  const AgentPids agent = agent_of(dir(), "node2");
  std::vector<int> node{agent.guardian, agent.worker};
  for (const auto& entry : fs::directory_iterator("/proc"))
    if (std::atoi(entry.path().filename().c_str()) > 0 &&
        text_in(entry.path() / "environ").find("/node2/") != std::string::npos &&
        fs::read_symlink(entry.path() / "cwd") == dir())
      node.push_back(std::atoi(entry.path().filename().c_str()));
  const double frozen = wall_now();
  for (const int one : node) kill(one, SIGSTOP);
  EXPECT_TRUE(wait_until([&] { return !times_of(dir(), "node.lost").empty(); }, 10.0));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  for (const int one : node) kill(one, SIGCONT);

  EXPECT_EQ(end(), 0);
  ASSERT_EQ(times_of(dir(), "node.lost").size(), 1u);
  EXPECT_LE(times_of(dir(), "node.lost")[0] - frozen, 5.0);
  EXPECT_EQ(times_of(dir(), "node.back").size(), 1u);
  EXPECT_EQ(granary_json({"status", dir().string(), "--json"})["counts"].integer_or("finished", 0), 9);
}

TEST_F(Agents, OfAPilotThatHangsEndTheirTasksBeforeItCanStartThemAgain) {
  write(honest_tasks(6, 2.0));
  start(3);
  ASSERT_TRUE(wait_until([&] { return fs::exists(dir() / "t2.log"); }, 10.0));
  kill(pid, SIGSTOP);
  EXPECT_TRUE(wait_until([&] { return processes_of_tasks(dir()) == 0; }, 5.0)) << "the lease is over";
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  kill(pid, SIGCONT);

  EXPECT_EQ(end(), 0);
  expect_each_finished_once(dir(), 6);
}

}  // namespace
}  // namespace granary::test
