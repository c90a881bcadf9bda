#include "pilot/task/spec_json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "common/json/io.hpp"
#include "pilot/schedule/check_tasks.hpp"

namespace granary::pilot {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Outcome {
  std::vector<TaskSpec> tasks;
  json::Problems problems;
  std::string texts() const { return problems.empty() ? "" : problems.error().message; }
};

Outcome read(const std::string& text, const Machine& machine = stated_machine(1, 4)) {
  Outcome outcome;
  const auto document = json::parse(text, "w.json");
  EXPECT_TRUE(document.has_value()) << text;
  json::Reader reader(*document, "w.json", outcome.problems);
  for (json::Reader& task : reader.items("tasks")) outcome.tasks.push_back(read_task(task));
  check_tasks(outcome.tasks, machine, "w.json", outcome.problems);
  return outcome;
}

TEST(TaskJson, ReadsEveryKeyWithUnits) {
  const auto [tasks, problems] = read(R"({"tasks": [{"name": "pre", "command": ["true"]},
    {"name": "a", "command": ["prog", "x y", ""], "env": {"K": "v"}, "dir": "runs/a", "ranks": 2, "threads": 2, "memory": "2 MB",
     "nodes": 1, "after": ["pre"], "priority": -3, "fill": true, "preempt": "kill", "timeout": "2 min", "retries": 4,
     "stop": {"signal": "SIGINT", "grace": "500 ms"}, "produces": ["out.h5"], "stdout": "o", "stderr": "e", "mpi": true}]})");

  ASSERT_TRUE(problems.empty()) << problems.error().message;
  const TaskSpec& a = tasks.at(1);
  EXPECT_THAT(a.command, ElementsAre("prog", "x y", ""));
  EXPECT_EQ(a.env.at(0), std::make_pair(std::string("K"), std::string("v")));
  EXPECT_EQ(a.dir, "runs/a");
  EXPECT_EQ(a.cores(), 4);
  EXPECT_EQ(a.memory_bytes, 2'000'000);
  EXPECT_EQ(a.priority, -3);
  EXPECT_TRUE(a.fill);
  EXPECT_EQ(a.preempt, Preempt::kill);
  EXPECT_DOUBLE_EQ(a.timeout, 120.0);
  EXPECT_EQ(a.retries, 4);
  EXPECT_EQ(stop_signal(a), SIGINT);
  EXPECT_DOUBLE_EQ(a.stop.grace, 0.5);
  EXPECT_THAT(a.produces, ElementsAre("out.h5"));
  EXPECT_EQ(spec_from_json(to_json(a)), a);
  EXPECT_EQ(spec_from_json(to_json(tasks.at(0))), tasks.at(0));
}

TEST(TaskJson, LetsNoRelativePathLeaveTheRunDirectory) {
  for (const char* key : {"dir", "stdout", "stderr"}) {
    for (const char* path : {"..", "../x", "a/../../x", "./a/b/../../../x"}) {
      const auto outcome =
          read(std::string(R"({"tasks": [{"name": "a", "command": ["b"], ")") + key + "\": \"" + path + "\"}]}");
      EXPECT_THAT(outcome.texts(), HasSubstr(std::string("/tasks/0/") + key)) << path;
      EXPECT_THAT(outcome.texts(), HasSubstr("leaves the run directory")) << path;
    }
    for (const char* path : {"x/../y", "a/..b", "/elsewhere/x"})
      EXPECT_TRUE(read(std::string(R"({"tasks": [{"name": "a", "command": ["b"], ")") + key + "\": \"" + path + "\"}]}")
                      .problems.empty())
          << path;
  }
  EXPECT_THAT(read(R"({"tasks": [{"name": "a", "command": ["b"], "dir": "d", "produces": ["../../x"]}]})").texts(),
              HasSubstr("leaves the run directory"));
}

TEST(TaskJson, ReportsEveryProblemAtOnce) {
  const std::string text = read(R"({"tasks": [
    {"name": "a/b", "command": "sleep 5", "timeout": 5, "rank": 2},
    {"name": "x", "command": []},
    {"command": ["true"], "stop": {"signal": "SIGFOO"}, "timeout": "5 kg", "ranks": 0}]})")
                               .texts();

  for (const char* pointer :
       {"/tasks/0/name", "/tasks/0/command", "/tasks/0/timeout", "/tasks/0/rank", "/tasks/1/command", "/tasks/2/name",
        "/tasks/2/stop/signal", "/tasks/2/timeout", "/tasks/2/ranks"}) {
    EXPECT_THAT(text, HasSubstr(std::string("w.json: ") + pointer));
  }
  EXPECT_THAT(text, HasSubstr("ranks"));
}

TEST(CheckTasks, NamesUnknownDependenciesWithASuggestion) {
  const std::string text =
      read(
          R"({"tasks": [{"name": "prepare", "command": ["x"]}, {"name": "b", "command": ["x"], "after": ["prepair"]}]})")
          .texts();

  EXPECT_THAT(text, HasSubstr("/tasks/1/after/0 is prepair"));
  EXPECT_THAT(text, HasSubstr("Did you mean \"prepare\"?"));
}

TEST(CheckTasks, TellsTheTasksOfACircle) {
  const std::string text =
      read(
          R"({"tasks": [{"name": "a", "command": ["x"], "after": ["c"]}, {"name": "b", "command": ["x"], "after": ["a"]},
                                    {"name": "c", "command": ["x"], "after": ["b"]}]})")
          .texts();

  EXPECT_THAT(text, HasSubstr("/tasks/0/after"));
  EXPECT_THAT(text, HasSubstr("a after c after b after a"));
}

TEST(CheckTasks, RefusesTwoTasksOfOneName) {
  EXPECT_THAT(read(R"({"tasks": [{"name": "a", "command": ["x"]}, {"name": "a", "command": ["y"]}]})").texts(),
              HasSubstr("/tasks/1/name is a: is the name of task 0 already"));
}

TEST(CheckTasks, RefusesATaskThatNeedsMoreThanTheMachineHas) {
  const std::string text =
      read(R"({"tasks": [{"name": "a", "command": ["x"], "ranks": 5}, {"name": "b", "command": ["x"], "threads": 5},
                                    {"name": "c", "command": ["x"], "memory": "3 GB"}, {"name": "d", "command": ["x"], "ranks": 2, "nodes": 2}]})",
           stated_machine(1, 4, 2'000'000'000))
          .texts();

  EXPECT_THAT(text, HasSubstr("/tasks/0/ranks is 5"));
  EXPECT_THAT(text, HasSubstr("needs 5 core(s) (5 rank(s) x 1 thread(s)), but there are 4 on 1 node(s)"));
  EXPECT_THAT(text, HasSubstr("/tasks/1/threads is 5"));
  EXPECT_THAT(text, HasSubstr("needs 3 GB on a node, but the largest has 2 GB"));
  EXPECT_THAT(text, HasSubstr("/tasks/3/"));
}

}  // namespace
}  // namespace granary::pilot
