// The whole pilot on virtual time: the same scheduler and life cycle as for real, without a process.
#include "pilot/pilot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <map>

#include "common/json/io.hpp"
#include "pilot/launch/simulated_launcher.hpp"
#include "pilot/loop/virtual_loop.hpp"
#include "pilot/task_list.hpp"
#include "tests/unit/pilot/builders.hpp"

namespace granary::pilot::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A simulated site; a task's running time is asked of `model`, 10 s by default.
struct Simulation {
  /// `past`: what an earlier pilot has left in the journal.
  explicit Simulation(Machine m, const std::vector<Record>& past = {})
      : journal(with(past)),
        machine(std::move(m)),
        opened(Pilot::open({"/campaign", machine}, loop, launcher, journal)),
        pilot(**opened) {
    pilot.on_end([this](const TaskEnd& end) { ended.push_back(end.name); });
  }
  VirtualLoop loop;
  std::function<SimulatedRun(const TaskSpec&)> model = [](const TaskSpec&) { return SimulatedRun{10.0}; };
  SimulatedLauncher launcher{loop, [this](const TaskSpec& spec) { return model(spec); }};
  Journal journal;
  Machine machine;
  Result<std::unique_ptr<Pilot>> opened;
  Pilot& pilot;
  std::vector<std::string> ended;

  Journal with(const std::vector<Record>& past) {
    Journal memory = Journal::in_memory([this] { return loop.wall_time(); });
    for (const Record& record : past) EXPECT_TRUE(memory.append(record.kind, record.payload).has_value());
    return memory;
  }
  TaskId submit(const TaskSpec& spec) {
    const auto id = pilot.submit(spec);
    EXPECT_TRUE(id.has_value()) << id.error().message;
    return *id;
  }
};

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

TEST(Pilot, GoesOnWhereStopAllLeftOff) {
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

TEST(Pilot, QueuesWhatRanWhenThePilotDiedAgain) {
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

TEST(Pilot, ReplayGivesTheSameTableAfterEveryRecord) {
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

TEST(Pilot, KilledBehindAnyRecordRunsEachTaskToItsEndOnceAndNoneThatFinishedAgain) {
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

TEST(Pilot, CompactsALongJournalAndKnowsTheSameOfEveryTask) {
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

TEST(Pilot, CountsTimeByTheLoopWhenTheWallClockJumps) {
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
