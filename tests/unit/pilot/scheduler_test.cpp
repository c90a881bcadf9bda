#include "pilot/schedule/scheduler.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pilot/schedule/explain.hpp"
#include "tests/unit/pilot/builders.hpp"

namespace granary::pilot::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A life with cores: decisions are carried out as the pilot would.
class Site : public Life {
 public:
  Scheduler scheduler;
  explicit Site(Machine machine) : scheduler(table, std::move(machine)) {}

  std::vector<Decision> decide(double deadline = std::numeric_limits<double>::infinity()) {
    const std::vector<Decision> decisions = scheduler.decide(time, deadline);
    for (const Decision& decision : decisions) std::visit([this](const auto& d) { carry_out(d); }, decision);
    return decisions;
  }
  void ends(TaskId id, int code = 0) { exit(id, code); }
  std::vector<int> cores(TaskId id) const { return table.at(id).last().pieces.back().cores.list(); }
  int node_of(int core) const { return scheduler.resources().node_of(core); }

 private:
  void carry_out(const StartTask& d) { place(d.id, d.cores.list()); }
  void carry_out(const SuspendFiller& d) { happens(Suspended{attempt(d.id)}); }
  void carry_out(const KillFiller& d) { happens(Preempted{attempt(d.id)}); }
  void carry_out(const ResumeFiller& d) { happens(Resumed{attempt(d.id), d.cores}); }
};

TEST(Scheduler, StartsNothingWhenNoCoreIsFree) {
  Site site(stated_machine(1, 2));
  site.submit(a_task("a").needs(2));
  const TaskId b = site.submit(a_task("b"));
  site.decide();

  EXPECT_THAT(site.decide(), IsEmpty());

  EXPECT_EQ(site.state(b), TaskState::ready);
}

TEST(Scheduler, GoesByPriorityThenByOrderOfSubmission) {
  Site site(stated_machine(1, 1));
  const TaskId a = site.submit(a_task("a")), b = site.submit(a_task("b").priority(5)),
               c = site.submit(a_task("c").priority(5));

  std::vector<TaskId> order;
  for (int k = 0; k < 3; ++k) {
    const auto decisions = site.decide();
    ASSERT_EQ(decisions.size(), 1u);
    order.push_back(std::get<StartTask>(decisions[0]).id);
    site.ends(order.back());
  }

  EXPECT_THAT(order, ElementsAre(b, c, a));
}

TEST(Scheduler, GivesAnMpiTaskNeighbouringCores) {
  Site site(stated_machine(1, 8));
  const TaskId a = site.submit(a_task("a").needs(2)), b = site.submit(a_task("b")),
               c = site.submit(a_task("c").needs(2));
  site.submit(a_task("d").needs(3));
  site.decide();
  site.ends(a);
  site.ends(b);
  site.ends(c);  // 0-4 are free
  const TaskId e = site.submit(a_task("e"));
  site.decide();
  site.table.at(e);

  const TaskId f = site.submit(a_task("f").needs(4));
  site.decide();

  EXPECT_THAT(site.cores(e), ElementsAre(0));
  EXPECT_THAT(site.cores(f), ElementsAre(1, 2, 3, 4));
}

TEST(Scheduler, DoesNotLetLaterSmallTasksKeepALargeOneWaiting) {
  Site site(stated_machine(1, 4));
  const TaskId first = site.submit(a_task("first").needs(2));
  site.decide();
  const TaskId large = site.submit(a_task("large").needs(4));
  for (int k = 0; k < 10; ++k) site.submit(a_task("small" + std::to_string(k)));

  EXPECT_THAT(site.decide(), IsEmpty());
  site.ends(first);
  site.decide();

  EXPECT_EQ(site.state(large), TaskState::running);
}

TEST(Scheduler, UsesTheCoresThatAWaitingLargeTaskWouldNotUse) {
  Site site(stated_machine(2, 4));
  site.submit(a_task("a").needs(2));
  site.submit(a_task("b").needs(3));
  site.decide();  // two cores are free on node 1, one on node 2
  const TaskId large = site.submit(a_task("large").needs(3)), small = site.submit(a_task("small")),
               other = site.submit(a_task("other"));

  site.decide();

  EXPECT_EQ(site.state(large), TaskState::ready);
  EXPECT_THAT(site.cores(small), ElementsAre(7)) << "node 2's core: large waits for node 1's";
  EXPECT_EQ(site.state(other), TaskState::ready);
}

TEST(Scheduler, SuspendsAFillerAtOnceForAReadyTaskAndResumesItAfterwards) {
  Site site(stated_machine(1, 2));
  const TaskId f0 = site.submit(a_task("f0").fills()), f1 = site.submit(a_task("f1").fills());
  site.decide();
  EXPECT_EQ(site.state(f0), TaskState::running);
  EXPECT_EQ(site.state(f1), TaskState::running);
  const TaskId task = site.submit(a_task("task").needs(2));

  site.decide();
  EXPECT_EQ(site.state(f0), TaskState::suspended);
  EXPECT_EQ(site.state(f1), TaskState::suspended);
  EXPECT_EQ(site.state(task), TaskState::running);
  site.ends(task);
  site.decide();

  EXPECT_EQ(site.state(f0), TaskState::running);
  EXPECT_EQ(site.state(f1), TaskState::running);
}

TEST(Scheduler, TakesAnIdleCoreRatherThanAFillers) {
  Site site(stated_machine(1, 2));
  const TaskId filler = site.submit(a_task("filler").fills());
  site.decide();

  const TaskId task = site.submit(a_task("task"));
  site.decide();

  EXPECT_EQ(site.state(filler), TaskState::running);
  EXPECT_THAT(site.cores(task), ElementsAre(1));
}

TEST(Scheduler, MovesASuspendedFillerToOtherIdleCores) {
  Site site(stated_machine(1, 2));
  const TaskId f = site.submit(a_task("f").fills());
  site.decide();
  const TaskId both = site.submit(a_task("both").needs(2));
  site.decide();
  const TaskId next = site.submit(a_task("next"));
  site.ends(both);

  site.decide();

  EXPECT_THAT(site.cores(next), ElementsAre(0));
  EXPECT_EQ(site.state(f), TaskState::running);
  EXPECT_THAT(site.cores(f), ElementsAre(1));
}

TEST(Scheduler, WaitsForAKilledFillerToEndBeforeItsCoresAreUsed) {
  Site site(stated_machine(1, 1));
  const TaskId filler = site.submit(a_task("filler").fills(Preempt::kill));
  site.decide();
  const TaskId task = site.submit(a_task("task"));

  const auto decisions = site.decide();
  ASSERT_EQ(decisions.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<KillFiller>(decisions[0]));
  EXPECT_THAT(site.decide(), IsEmpty()) << "asked once";
  site.ends(filler);
  site.decide();

  EXPECT_EQ(site.state(task), TaskState::running);
  EXPECT_EQ(site.state(filler), TaskState::ready);
}

TEST(Scheduler, StartsALightTaskOnAFullMachine) {
  Site site(stated_machine(1, 1));
  site.submit(a_task("a"));
  site.decide();

  const TaskId monitor = site.submit(a_task("monitor").light());
  site.decide();

  EXPECT_EQ(site.state(monitor), TaskState::running);
  EXPECT_THAT(site.cores(monitor), IsEmpty());
}

TEST(Scheduler, KeepsTheMemoryOfANodeWithinItsBounds) {
  Site site(stated_machine(1, 4, 1000));
  const TaskId a = site.submit(a_task("a").memory(600)), b = site.submit(a_task("b").memory(600));
  site.decide();
  EXPECT_EQ(site.state(b), TaskState::ready);

  site.ends(a);
  site.decide();

  EXPECT_EQ(site.state(b), TaskState::running);
}

TEST(Scheduler, SpreadsATaskOverAsFewNodesAsItCanOrOverAsManyAsAsked) {
  Site site(stated_machine(4, 4));
  const TaskId a = site.submit(a_task("a").needs(4)), b = site.submit(a_task("b").needs(6)),
               c = site.submit(a_task("c").needs(2).nodes(2));

  site.decide();

  EXPECT_THAT(site.cores(a), ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(site.cores(b).size(), 6u);
  EXPECT_EQ(site.node_of(site.cores(b)[0]), site.node_of(site.cores(b)[2]));
  EXPECT_NE(site.node_of(site.cores(b)[2]), site.node_of(site.cores(b)[3]));
  EXPECT_NE(site.node_of(site.cores(c)[0]), site.node_of(site.cores(c)[1]));
}

TEST(Scheduler, FillsSmallGapsOfANodeBeforeBreakingIntoAnEmptyOne) {
  Site site(stated_machine(2, 4));
  site.submit(a_task("a").needs(3));
  site.decide();

  const TaskId b = site.submit(a_task("b"));
  site.decide();

  EXPECT_THAT(site.cores(b), ElementsAre(3));
}

TEST(Explain, SaysWhatATaskWaitsFor) {
  Site site(stated_machine(1, 2));
  const TaskId a = site.submit(a_task("a").needs(2)), b = site.submit(a_task("b").after({"a"})),
               c = site.submit(a_task("c"));
  const TaskId f = site.submit(a_task("f").fills());
  site.decide();
  const auto why = [&](TaskId id) { return explain(site.table.at(id), site.table, site.scheduler, site.time, false); };

  EXPECT_THAT(why(b), HasSubstr("waits for \"a\" (running) to finish"));
  EXPECT_THAT(why(c), HasSubstr("needs 1 core(s), 0 of 2 cores are free: \"a\" on 0-1"));
  EXPECT_THAT(why(f), HasSubstr("a filler starts only when no other task (1 ready) wants the cores"));
  site.ends(a, 4);
  EXPECT_THAT(why(a), HasSubstr("failed: exit code 4"));
  EXPECT_THAT(why(a), HasSubstr("attempt 1: failed for"));
  EXPECT_THAT(why(b), HasSubstr("comes after task \"a\", which failed"));
}

}  // namespace
}  // namespace granary::pilot::testing
