#include "pilot/task/update.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "common/json/text.hpp"
#include "tests/unit/pilot/builders.hpp"

namespace granary::pilot::testing {
namespace {

using ::testing::HasSubstr;

TEST(Update, StartsATaskOnlyAfterAllItDependsOnHasFinished) {
  Life life;
  const TaskId a = life.submit(a_task("a")), b = life.submit(a_task("b"));
  const TaskId c = life.submit(a_task("c").after({"a", "b"}));
  life.place(a, {0});
  life.place(b, {1});

  life.exit(a);
  EXPECT_EQ(life.state(c), TaskState::waiting);
  life.exit(b);

  EXPECT_EQ(life.state(c), TaskState::ready);
}

TEST(Update, FailsWhatComesAfterAFailedTaskAndSaysWhy) {
  Life life;
  const TaskId a = life.submit(a_task("a")), b = life.submit(a_task("b").after({"a"})),
               c = life.submit(a_task("c").after({"b"}));
  life.place(a, {0});

  const auto actions = life.exit(a, 7);

  EXPECT_EQ(life.state(a), TaskState::failed);
  EXPECT_EQ(life.reason(a), "exit code 7");
  EXPECT_EQ(life.state(b), TaskState::failed);
  EXPECT_EQ(life.reason(b), "comes after task \"a\", which failed");
  EXPECT_EQ(life.state(c), TaskState::failed);
  EXPECT_EQ(
      std::count_if(actions.begin(), actions.end(), [](const Action& x) { return std::holds_alternative<Report>(x); }),
      3);
}

TEST(Update, FailsATaskSubmittedAfterItsDependencyFailed) {
  Life life;
  const TaskId a = life.submit(a_task("a"));
  life.place(a, {0});
  life.exit(a, 1);

  const TaskId late = life.submit(a_task("late").after({"a"}));

  EXPECT_EQ(life.state(late), TaskState::failed);
}

TEST(Update, TriesAFailedTaskAgainAsOftenAsAsked) {
  Life life;
  const TaskId a = life.submit(a_task("a").retries(2));

  for (int attempt = 1; attempt <= 2; ++attempt) {
    life.place(a, {0});
    life.exit(a, 1);
    EXPECT_EQ(life.state(a), TaskState::ready) << attempt;
  }
  life.place(a, {0});
  life.exit(a, 1);

  EXPECT_EQ(life.state(a), TaskState::failed);
  EXPECT_EQ(life.table.at(a).attempts.size(), 3u);
}

TEST(Update, DoesNotRetryWhatCannotBeStarted) {
  Life life;
  const TaskId a = life.submit(a_task("a").retries(5));
  life.place(a, {0});

  life.happens(StartFailed{life.attempt(a), "nosuch: no such program"});

  EXPECT_EQ(life.state(a), TaskState::failed);
  EXPECT_EQ(life.reason(a), "nosuch: no such program");
}

TEST(Update, CallsExitCodeZeroWithoutTheFilesItShouldProduceAFailure) {
  Life life;
  const TaskId a = life.submit(a_task("a"));
  life.place(a, {0});

  life.happens(Exited{life.attempt(a), 0, 0, 0.1, {"out.h5", "log"}});

  EXPECT_EQ(life.state(a), TaskState::failed);
  EXPECT_EQ(life.reason(a), "ended with exit code 0, but did not produce out.h5, log");
}

TEST(Update, AsksARunningTaskToEndFirstAndKillsItAfterItsGrace) {
  Life life;
  TaskSpec spec = a_task("a");
  spec.stop.grace = 3.0;
  const TaskId a = life.submit(spec);
  life.place(a, {0});

  const auto asked = life.happens(StopAsked{a, "enough", false});
  ASSERT_NE(find_action<AskToEnd>(asked), nullptr);
  EXPECT_EQ(find_action<AskToEnd>(asked)->signal, SIGTERM);
  ASSERT_NE(find_action<SetAlarm>(asked), nullptr);
  EXPECT_EQ(find_action<SetAlarm>(asked)->after, 3.0);
  EXPECT_EQ(find_action<Kill>(asked), nullptr);
  const auto killed = life.happens(GraceOver{life.attempt(a)});
  EXPECT_NE(find_action<Kill>(killed), nullptr);
  life.happens(Exited{life.attempt(a), -1, SIGKILL, 0.1, {}});

  EXPECT_EQ(life.state(a), TaskState::stopped);
  EXPECT_EQ(life.reason(a), "enough");
}

TEST(Update, AsksMpiTasksToEndWithTheSignalThatMpirunForwards) {
  EXPECT_EQ(stop_signal(a_task("a").needs(2)), SIGUSR1);
  EXPECT_EQ(stop_signal(a_task("a").needs(1, 2)), SIGTERM);
}

TEST(Update, StopsAWaitingTaskAtOnceAndWhatComesAfterIt) {
  Life life;
  const TaskId a = life.submit(a_task("a")), b = life.submit(a_task("b").after({"a"}));

  life.happens(StopAsked{a, "enough", false});

  EXPECT_EQ(life.state(a), TaskState::stopped);
  EXPECT_EQ(life.state(b), TaskState::stopped);
}

TEST(Update, KeepsWhatTheEndOfThePilotStoppedForTheNextOne) {
  Life life;
  const TaskId a = life.submit(a_task("a")), b = life.submit(a_task("b").after({"a"}));
  life.place(a, {0});
  life.happens(StopAsked{a, "interrupted", true});
  life.happens(StopAsked{b, "interrupted", true});
  life.exit(a);
  EXPECT_EQ(life.state(a), TaskState::stopped);
  EXPECT_EQ(life.state(b), TaskState::waiting);

  life.happens(Reopened{a});

  EXPECT_EQ(life.state(a), TaskState::ready);
}

TEST(Update, FailsATaskThatRunsLongerThanItsTimeout) {
  Life life;
  const TaskId a = life.submit(a_task("a").timeout(5.0));
  const auto started = life.place(a, {0});
  ASSERT_NE(find_action<SetAlarm>(started), nullptr);
  EXPECT_EQ(find_action<SetAlarm>(started)->after, 5.0);

  EXPECT_NE(find_action<AskToEnd>(life.happens(TimedOut{life.attempt(a)})), nullptr);
  life.exit(a, 0);

  EXPECT_EQ(life.state(a), TaskState::failed);
  EXPECT_EQ(life.reason(a), "ran longer than its timeout of 5 s");
}

TEST(Update, DoesNotCountSuspensionTowardsTheTimeout) {
  Life life;
  const TaskId a = life.submit(a_task("a").fills().timeout(10.0));
  life.place(a, {0});                        // at 2 s
  life.happens(Suspended{life.attempt(a)});  // at 3 s: it ran 1 s
  life.time += 100.0;

  const auto resumed = life.happens(Resumed{life.attempt(a), {1}});

  ASSERT_NE(find_action<SetAlarm>(resumed), nullptr);
  EXPECT_DOUBLE_EQ(find_action<SetAlarm>(resumed)->after, 9.0);
}

TEST(Update, QueuesALostTaskAgainWithoutCountingAFailure) {
  Life life;
  const TaskId a = life.submit(a_task("a"));
  life.place(a, {0});

  life.happens(Lost{life.attempt(a), "the pilot died"});

  EXPECT_EQ(life.state(a), TaskState::ready);
  EXPECT_EQ(life.table.at(a).failures, 0);
  EXPECT_EQ(life.table.at(a).last().outcome, TaskState::lost);
}

TEST(Update, QueuesAKilledFillerAgainWithoutCountingAFailure) {
  Life life;
  const TaskId a = life.submit(a_task("a").fills(Preempt::kill));
  life.place(a, {0});
  EXPECT_NE(find_action<Kill>(life.happens(Preempted{life.attempt(a)})), nullptr);

  life.happens(Exited{life.attempt(a), -1, SIGKILL, 0.1, {}});

  EXPECT_EQ(life.state(a), TaskState::ready);
  EXPECT_EQ(life.table.at(a).failures, 0);
}

TEST(Update, IgnoresEventsOfAttemptsThatAreOver) {
  Life life;
  const TaskId a = life.submit(a_task("a").retries(1));
  life.place(a, {0});
  const AttemptId first = life.attempt(a);
  life.exit(a, 1);
  life.place(a, {1});

  EXPECT_TRUE(life.happens(Exited{first, 0, 0, 0.0, {}}).empty());
  EXPECT_TRUE(life.happens(GraceOver{first}).empty());
  EXPECT_TRUE(life.happens(Placed{{a, 3}, {0}}).empty());

  EXPECT_EQ(life.state(a), TaskState::running);
}

TEST(Event, ReadsBackFromJsonAsItWas) {
  const AttemptId attempt{TaskId{3}, 2};
  const std::vector<Event> events{{1.5, Submitted{TaskId{3}, a_task("a").needs(2, 3).after({"b"}).timeout(4.5)}},
                                  {2.0, Placed{attempt, {0, 5}}},
                                  {2.0, Started{attempt, 123, 456789012345}},
                                  {2.0, StartFailed{attempt, "no"}},
                                  {2.0, Exited{attempt, 3, 0, 0.25, {"x/y"}}},
                                  {2.0, StopAsked{TaskId{3}, "why", true}},
                                  {2.0, TimedOut{attempt}},
                                  {2.0, GraceOver{attempt}},
                                  {2.0, Suspended{attempt}},
                                  {2.0, Resumed{attempt, {1}}},
                                  {2.0, Preempted{attempt}},
                                  {2.0, Lost{attempt, "gone"}},
                                  {2.0, Reopened{TaskId{3}}}};
  for (const Event& event : events) {
    std::string text, again;
    append(text, event);
    const auto back = event_from_json(kind_of(event), *json::parse_text(text));

    ASSERT_TRUE(back.has_value()) << kind_of(event);
    EXPECT_EQ(back->what.index(), event.what.index());
    append(again, *back);
    EXPECT_EQ(again, text);
  }
  EXPECT_FALSE(event_from_json("task.dance", json::Value::object({{"id", 1}})).has_value());
}

}  // namespace
}  // namespace granary::pilot::testing
