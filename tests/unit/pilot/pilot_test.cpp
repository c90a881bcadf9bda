// The whole pilot on virtual time; what it makes of an earlier one's journal is in pilot_resume_test.
#include "pilot/pilot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "common/json/io.hpp"
#include "pilot/task_list.hpp"
#include "tests/unit/pilot/simulation.hpp"

namespace granary::pilot::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Pilot, RunsTasksInOrderOfDependencyAndCountsTheTime) {
  Simulation site(stated_machine(1, 2));

  const auto summary = run_task_list({a_task("c").after({"a", "b"}), a_task("a"), a_task("b")}, site.pilot, site.loop);

  ASSERT_TRUE(summary.has_value());
  EXPECT_EQ(summary->exit, Exit::ok);
  EXPECT_EQ(summary->finished, 3);
  EXPECT_DOUBLE_EQ(summary->seconds, 20.0);
  EXPECT_DOUBLE_EQ(summary->usage.busy, 30.0);
  EXPECT_DOUBLE_EQ(summary->usage.total, 40.0);
  EXPECT_THAT(site.ended, ElementsAre("a", "b", "c"));
}

TEST(Pilot, StartsNothingWithinSubmit) {
  Simulation site(stated_machine(1, 1));

  const TaskId a = site.submit(a_task("a"));

  EXPECT_EQ(site.pilot.state(a), TaskState::ready);
  EXPECT_FALSE(site.pilot.idle());
}

TEST(Pilot, KeepsIdleCoresBusyWithFillersAndTakesThemBackAtOnce) {
  Simulation site(stated_machine(1, 2));
  site.model = [](const TaskSpec& spec) { return SimulatedRun{spec.fill ? 30.0 : 10.0}; };
  site.submit(a_task("f0").fills());
  site.submit(a_task("f1").fills());
  site.loop.at(5.0, [&] { site.submit(a_task("urgent").needs(2)); });

  site.loop.run();

  const auto timeline = site.pilot.timeline();
  ASSERT_EQ(timeline.size(), 5u);
  EXPECT_DOUBLE_EQ(timeline[0].start, 0.0);
  EXPECT_DOUBLE_EQ(timeline[0].end, 5.0);
  EXPECT_EQ(timeline[0].outcome, TaskState::suspended);
  EXPECT_DOUBLE_EQ(timeline[1].start, 15.0);
  EXPECT_DOUBLE_EQ(timeline[1].end, 40.0);
  EXPECT_EQ(timeline[1].outcome, TaskState::finished);
  EXPECT_EQ(timeline[4].name, "urgent");
  EXPECT_DOUBLE_EQ(timeline[4].start, 5.0);
  EXPECT_DOUBLE_EQ(site.pilot.usage().busy, 80.0);
  EXPECT_DOUBLE_EQ(site.pilot.usage().fillers, 60.0);
}

TEST(Pilot, StopsGracefullyAndKillsAfterTheGraceTime) {
  Simulation site(stated_machine(1, 2));
  site.model = [](const TaskSpec& spec) {
    SimulatedRun run{1000.0};
    run.stop_after = 2.0;
    run.ignores_stop = spec.name == "deaf";
    return run;
  };
  TaskSpec deaf = a_task("deaf");
  deaf.stop.grace = 7.0;
  const TaskId good_id = site.submit(a_task("good")), deaf_id = site.submit(deaf);
  site.loop.at(10.0, [&] {
    site.pilot.stop(good_id, "enough");
    site.pilot.stop(deaf_id, "enough");
  });

  site.loop.run();

  EXPECT_DOUBLE_EQ(site.pilot.end(good_id)->end, 12.0);
  EXPECT_EQ(site.pilot.end(good_id)->exit_code, 0);
  EXPECT_EQ(site.pilot.end(good_id)->state, TaskState::stopped);
  EXPECT_EQ(site.pilot.end(good_id)->reason, "enough");
  EXPECT_DOUBLE_EQ(site.pilot.end(deaf_id)->end, 17.0);
  EXPECT_EQ(site.pilot.end(deaf_id)->signal, SIGKILL);
}

TEST(Pilot, TakesATaskItKnowsForTheSameAndTellsItsEndAgain) {
  Simulation site(stated_machine(1, 1));
  const TaskId a = site.submit(a_task("a"));
  site.loop.run();
  site.ended.clear();

  EXPECT_EQ(site.submit(a_task("a")), a);
  site.loop.run();
  const auto other = site.pilot.submit(a_task("a").priority(3));

  EXPECT_THAT(site.ended, ElementsAre("a"));
  ASSERT_FALSE(other.has_value());
  EXPECT_THAT(other.error().message, HasSubstr("is in the journal with other settings"));
}

TEST(Pilot, RefusesTasksThatCouldNeverStart) {
  Simulation site(stated_machine(1, 2));

  EXPECT_THAT(site.pilot.submit(a_task("wide").needs(3)).error().message, HasSubstr("needs 3 core(s)"));
  EXPECT_THAT(site.pilot.submit(a_task("late").after({"nobody"})).error().message, HasSubstr("comes after \"nobody\""));
}

TEST(Pilot, AnswersRequestsOfItsSocket) {
  Simulation site(stated_machine(1, 1));
  site.submit(a_task("first"));
  site.submit(a_task("second"));
  site.loop.run_until(1.0);

  const json::Value status = site.pilot.answer(json::Value::object({{"ask", "status"}}));
  EXPECT_EQ(status["counts"].integer_or("running", 0), 1);
  EXPECT_EQ(status["tasks"].items().at(0).text_or("name", ""), "first");
  EXPECT_THAT(site.pilot.answer(json::Value::object({{"ask", "explain"}, {"task", "second"}})).text_or("text", ""),
              HasSubstr("ready"));
  EXPECT_THAT(site.pilot.answer(json::Value::object({{"ask", "explain"}, {"task", "secnd"}})).text_or("error", ""),
              HasSubstr("Did you mean \"second\"?"));
  EXPECT_THAT(site.pilot.answer(json::Value::object({{"ask", "dance"}})).text_or("error", ""),
              HasSubstr("known are status"));
  site.pilot.answer(json::Value::object({{"ask", "stop"}, {"reason", "user"}}));
  EXPECT_TRUE(site.pilot.stopping());
}

TEST(Pilot, QueuesWhatRanOnALostNodeAgainElsewhere) {
  Simulation site(stated_machine(2, 2));
  const TaskId a = site.submit(a_task("a").needs(2)), b = site.submit(a_task("b").needs(2));
  site.loop.at(4.0, [&] { site.pilot.lose_node(0, "no heartbeat"); });

  site.loop.run();

  const int lost = site.pilot.timeline()[0].cores[0] < 2 ? 0 : 1;
  const TaskId victim = lost == 0 ? a : b, other = lost == 0 ? b : a;
  EXPECT_EQ(site.pilot.end(other)->attempt, 1);
  EXPECT_EQ(site.pilot.end(victim)->attempt, 2);
  EXPECT_EQ(site.pilot.end(victim)->state, TaskState::finished);
  EXPECT_THAT(site.pilot.end(victim)->cores.list(), ElementsAre(2, 3)) << "the lost node's cores are out";
  EXPECT_DOUBLE_EQ(site.pilot.end(victim)->start, 10.0) << "no earlier: the other node was busy";
  EXPECT_THAT(*site.pilot.explain(site.pilot.spec(victim).name), HasSubstr("node node1 was lost: no heartbeat"));
}

TEST(Pilot, EndsTheRestOfATaskThatLostOneOfItsNodesAndWaitsForTheNodesReturn) {
  Simulation site(stated_machine(2, 2));
  const TaskId wide = site.submit(a_task("wide").needs(4));
  site.loop.at(4.0, [&] { site.pilot.lose_node(1, "power cut"); });
  site.loop.at(50.0, [&] { site.pilot.regain_node(1); });

  site.loop.run();

  EXPECT_EQ(site.pilot.end(wide)->state, TaskState::finished);
  EXPECT_EQ(site.pilot.end(wide)->attempt, 2);
  EXPECT_DOUBLE_EQ(site.pilot.end(wide)->start, 50.0);
  int abandoned = 0;
  for (const Record& record : site.journal.records()) abandoned += record.kind == "task.abandon";
  EXPECT_EQ(abandoned, 1);
}

TEST(Pilot, StartsOnlyWhatCanEndBeforeTheAllocationDoesAndEndsWhenNothingElseIsLeft) {
  Simulation site(stated_machine(1, 1));
  site.model = [](const TaskSpec&) { return SimulatedRun{60.0}; };
  TaskSpec checkpointing = a_task("checkpointing").timeout(1e6);
  checkpointing.resumable = true;
  TaskSpec expected = a_task("expected").timeout(1e6);
  expected.expected = 70.0;
  const TaskId too_long = site.submit(a_task("too-long").timeout(200.0)), fits = site.submit(expected),
               resumable = site.submit(checkpointing);
  site.pilot.deadline(site.loop.wall_time() + 150.0);

  site.loop.run();

  EXPECT_EQ(site.pilot.end(fits)->state, TaskState::finished);
  EXPECT_EQ(site.pilot.end(resumable)->state, TaskState::finished);
  EXPECT_EQ(site.pilot.state(too_long), TaskState::ready) << "for the next allocation";
  EXPECT_TRUE(site.pilot.stopping());
  EXPECT_TRUE(site.pilot.idle());
}

TEST(Pilot, TakesTasksFromItsSocketWithEveryProblemAtOnce) {
  Simulation site(stated_machine(1, 1));
  const auto submit = [&](const std::string& text) {
    return site.pilot.answer(json::Value::object({{"ask", "submit"}, {"task", *json::parse(text, "task")}}));
  };

  const json::Value good = submit(R"({"name": "late", "command": ["true"], "timeout": "5 s"})");
  const json::Value bad = submit(R"({"name": "a b", "command": "true", "tiemout": "5 s", "dir": "../x"})");

  EXPECT_EQ(good.text_or("submitted", ""), "late");
  const std::string error = bad.text_or("error", "");
  for (const char* part : {"/name", "/command", "Did you mean \"timeout\"", "/dir", "leaves the run directory"})
    EXPECT_THAT(error, HasSubstr(part));
  EXPECT_THAT(submit(R"({"name": "wide", "command": ["true"], "ranks": 9})").text_or("error", ""),
              HasSubstr("needs 9 core(s)"));
  site.loop.run();
  EXPECT_THAT(site.ended, ElementsAre("late"));
}

TEST(Pilot, StopsGracefullyWhenTheJournalCannotBeWrittenAndSaysWhy) {
  VirtualLoop loop;
  SimulatedLauncher launcher(loop, [](const TaskSpec&) { return SimulatedRun{10.0}; });
  auto journal = Journal::open("/dev/full");
  ASSERT_TRUE(journal.has_value());

  const auto pilot = Pilot::open({"/campaign", stated_machine(1, 1)}, loop, launcher, *journal);

  ASSERT_FALSE(pilot.has_value());
  EXPECT_THAT(pilot.error().message, HasSubstr("the disk is full"));
}

TEST(Pilot, IsDeterministicInSimulation) {
  const auto journal_of = [] {
    Simulation site(stated_machine(2, 3));
    site.model = [](const TaskSpec& spec) { return SimulatedRun{1.0 + static_cast<double>(spec.name.size() % 3)}; };
    for (int k = 0; k < 40; ++k)
      site.submit(a_task("t" + std::string(static_cast<std::size_t>(k % 5), 'x') + std::to_string(k)).needs(1 + k % 3));
    site.loop.run();
    std::string text;
    for (const Record& record : site.journal.records()) {
      if (record.kind != "pilot.open") text += record.kind + json::dump(record.payload) + "\n";
    }
    return text;
  };

  EXPECT_EQ(journal_of(), journal_of());
}

}  // namespace
}  // namespace granary::pilot::testing
