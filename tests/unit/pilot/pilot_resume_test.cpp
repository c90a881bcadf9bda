// A pilot that takes up what an earlier one has left: the journal replayed, after a stop, a kill, at any record.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <map>

#include "tests/unit/pilot/simulation.hpp"

namespace granary::pilot::testing {
namespace {

using ::testing::HasSubstr;

TEST(PilotResume, GoesOnWhereStopAllLeftOff) {
  Simulation first(stated_machine(1, 1));
  first.submit(a_task("a"));
  first.submit(a_task("b"));
  first.submit(a_task("c"));
  first.loop.at(15.0, [&] { first.pilot.stop_all("walltime"); });
  first.loop.run();
  EXPECT_TRUE(first.pilot.idle());
  EXPECT_EQ(first.pilot.end(TaskId{1})->state, TaskState::stopped);

  auto second = Pilot::open({"/campaign", first.machine}, first.loop, first.launcher, first.journal);
  ASSERT_TRUE(second.has_value()) << second.error().message;
  first.loop.run();

  ASSERT_EQ((*second)->ends().size(), 3u);
  for (const TaskEnd& end : (*second)->ends()) EXPECT_EQ(end.state, TaskState::finished) << end.name;
  EXPECT_EQ((*second)->end(TaskId{0})->attempt, 1) << "what has finished is not run again";
  EXPECT_EQ((*second)->end(TaskId{1})->attempt, 2);
}

TEST(PilotResume, QueuesWhatRanWhenThePilotDiedAgain) {
  Simulation first(stated_machine(1, 1));
  first.submit(a_task("a"));
  first.submit(a_task("b"));
  first.loop.run_until(12.0);  // b runs; then the pilot is no more

  VirtualLoop loop;
  SimulatedLauncher launcher(loop, [](const TaskSpec&) { return SimulatedRun{10.0}; });
  Journal journal = Journal::in_memory();
  for (const Record& record : first.journal.records())
    ASSERT_TRUE(journal.append(record.kind, record.payload).has_value());
  auto second = Pilot::open({"/campaign", first.machine}, loop, launcher, journal);
  ASSERT_TRUE(second.has_value()) << second.error().message;
  loop.run();

  EXPECT_EQ((*second)->end(TaskId{0})->attempt, 1);
  EXPECT_EQ((*second)->end(TaskId{1})->attempt, 2);
  EXPECT_EQ((*second)->end(TaskId{1})->state, TaskState::finished);
  EXPECT_THAT(*(*second)->explain("b"), HasSubstr("attempt 1: lost"));
}

TEST(PilotResume, ReplayGivesTheSameTableAfterEveryRecord) {
  Simulation site(stated_machine(1, 2));
  site.model = [](const TaskSpec& spec) { return SimulatedRun{7.0, spec.name == "bad" ? 3 : 0}; };
  site.submit(a_task("a").fills());
  site.submit(a_task("bad").retries(1));
  site.submit(a_task("after-bad").after({"bad"}));
  site.loop.at(3.0, [&] { site.submit(a_task("wide").needs(2)); });
  site.loop.run();

  Table table;
  for (const Record& record : site.journal.records()) {
    if (!record.kind.starts_with("task.")) continue;
    const auto event = event_from_json(record.kind, record.payload);
    ASSERT_TRUE(event.has_value());
    (void)update(table, *event);
    const Status sound = table.check_invariants();
    ASSERT_TRUE(sound.has_value()) << sound.error().message;
  }

  for (const Task& task : table.tasks) EXPECT_EQ(task.state, site.pilot.state(task.id)) << task.spec.name;
  EXPECT_EQ(table.tasks.at(1).attempts.size(), 2u);
}

TEST(PilotResume, KilledBehindAnyRecordRunsEachTaskToItsEndOnceAndNoneThatFinishedAgain) {
  const auto model = [](const TaskSpec& spec) {
    return SimulatedRun{spec.fill ? 9.0 : 4.0, spec.name == "bad" ? 1 : 0};
  };
  const auto queue_all = [](Pilot& pilot) {
    std::vector<TaskSpec> tasks{a_task("f").fills(), a_task("k").fills(Preempt::kill), a_task("bad").retries(1),
                                a_task("m").light(), a_task("wide").needs(3),          a_task("late").after({"wide"})};
    for (int k = 0; k < 6; ++k) tasks.push_back(a_task("t" + std::to_string(k)).needs(1 + k % 2));
    for (const TaskSpec& task : tasks) ASSERT_TRUE(pilot.submit(task).has_value());
  };
  Simulation whole(stated_machine(1, 3));
  whole.model = model;
  queue_all(whole.pilot);
  whole.loop.run();
  const std::vector<Record> records = whole.journal.records();
  ASSERT_GT(records.size(), 40u);

  for (std::size_t kept = 1; kept <= records.size(); ++kept) {
    Simulation next(stated_machine(1, 3),
                    std::vector<Record>(records.begin(), records.begin() + static_cast<int>(kept)));
    next.model = model;
    queue_all(next.pilot);
    next.loop.run();

    ASSERT_EQ(next.pilot.ends().size(), 12u) << "killed behind record " << kept;
    std::map<std::int64_t, int> finished;
    for (const Record& record : next.journal.records()) {
      const std::int64_t id = record.payload.integer_or("id", -1);
      if (record.kind == "task.place") {
        EXPECT_EQ(finished[id], 0) << "task " << id << ", killed behind record " << kept;
      }
      finished[id] += record.kind == "task.exit" && record.payload.integer_or("exit_code", -1) == 0;
    }
    for (const TaskEnd& end : next.pilot.ends()) {
      EXPECT_EQ(finished[end.id.value], end.name == "bad" ? 0 : 1) << end.name << ", killed behind record " << kept;
      EXPECT_EQ(end.state, end.name == "bad" ? TaskState::failed : TaskState::finished);
    }
  }
}

/// One life of a pilot on a journal file.
struct FileLife {
  VirtualLoop loop;
  SimulatedLauncher launcher{loop, [](const TaskSpec& spec) {
                               return SimulatedRun{spec.fill ? 25.0 : 3.0, spec.name == "bad" ? 3 : 0};
                             }};
  Journal journal;
  std::unique_ptr<Pilot> pilot;

  FileLife(const std::filesystem::path& dir, std::uint64_t compact_above)
      : journal(*Journal::open(dir / "journal.jsonl", [this] { return 1000.0 + loop.wall_time(); })) {
    auto opened = Pilot::open({dir, stated_machine(1, 2), compact_above}, loop, launcher, journal);
    EXPECT_TRUE(opened.has_value()) << opened.error().message;
    pilot = std::move(*opened);
  }
  std::string told() const {
    std::string text;
    for (const TaskEnd& end : pilot->ends()) text += *pilot->explain(end.name);
    return text;
  }
};

TEST(PilotResume, CompactsALongJournalAndKnowsTheSameOfEveryTask) {
  const std::filesystem::path dir =
      std::filesystem::temp_directory_path() / ("granary_compact_" + std::to_string(::getpid()));
  std::filesystem::create_directories(dir);
  std::string before;
  {
    FileLife first(dir, 10'000);
    (void)first.pilot->submit(a_task("filler").fills());
    (void)first.pilot->submit(a_task("bad").retries(1));
    (void)first.pilot->submit(a_task("after-bad").after({"bad"}));
    for (int k = 0; k < 12; ++k) (void)first.pilot->submit(a_task("t" + std::to_string(k)).needs(1 + k % 2));
    ASSERT_TRUE(first.journal.append("other.note", json::Value::object({{"text", "kept"}})).has_value());
    (void)first.pilot->submit(a_task("late").after({"t11"}));
    first.loop.run_until(13.0);
    before = first.told();
    EXPECT_GT(first.journal.n_records(), 38u);
  }
  {
    FileLife second(dir, 20);
    EXPECT_EQ(second.journal.n_records(), 1 + 1 + 16 + 1u) << "two openings, a stranger's note, sixteen tasks";
    ASSERT_EQ(second.journal.records("other.").size(), 1u);
    EXPECT_EQ(second.journal.records("other.")[0].payload.text_or("text", ""), "kept");
    EXPECT_NEAR(*second.journal.first_wall_time(), 1000.0, 1e-6);
    EXPECT_EQ(second.told(), before);
  }
  FileLife third(dir, 10'000);  // from the compacted journal
  EXPECT_EQ(third.told(), before);
  EXPECT_EQ(third.pilot->submit(a_task("bad").retries(1)).value_or(TaskId{}), TaskId{1}) << "the same task";
  third.loop.run();
  EXPECT_EQ(third.pilot->ends().size(), 16u);
  EXPECT_EQ(third.pilot->end(*third.pilot->find("late"))->state, TaskState::finished);
  EXPECT_EQ(third.pilot->end(*third.pilot->find("after-bad"))->state, TaskState::failed);
  std::filesystem::remove_all(dir);
}

TEST(PilotResume, CountsTimeByTheLoopWhenTheWallClockJumps) {
  double wall = 5000.0;
  VirtualLoop loop;
  SimulatedLauncher launcher(loop, [](const TaskSpec&) { return SimulatedRun{10.0}; });
  Journal journal = Journal::in_memory([&] { return wall; });
  auto pilot = *Pilot::open({"/campaign", stated_machine(1, 1)}, loop, launcher, journal);
  (void)pilot->submit(a_task("a").timeout(15.0));
  loop.at(5.0, [&] { wall -= 3600.0; });  // somebody sets the clock back an hour, then a day forward
  loop.at(7.0, [&] { wall += 90000.0; });
  loop.run();

  EXPECT_EQ(pilot->end(TaskId{0})->state, TaskState::finished);
  EXPECT_DOUBLE_EQ(pilot->end(TaskId{0})->end, 10.0);
  Journal copy = Journal::in_memory();
  for (const Record& record : journal.records()) ASSERT_TRUE(copy.append(record.kind, record.payload).has_value());
  const auto second = *Pilot::open({"/campaign", stated_machine(1, 1)}, loop, launcher, copy);
  EXPECT_DOUBLE_EQ(second->now(), 10.0);
}

}  // namespace
}  // namespace granary::pilot::testing
