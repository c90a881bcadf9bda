// The pilot with real processes on this machine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <optional>

#include "common/files.hpp"
#include "pilot/launch/local_launcher.hpp"
#include "pilot/launch/prepared_processes.hpp"
#include "pilot/launch/run_program.hpp"
#include "pilot/launch/spawn.hpp"
#include "pilot/task_list.hpp"

namespace granary::pilot {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TaskSpec task(std::string name, std::vector<std::string> command) {
  TaskSpec spec;
  spec.name = std::move(name);
  spec.command = std::move(command);
  return spec;
}
TaskSpec script(std::string name, const std::string& text) { return task(std::move(name), {"/bin/sh", "-c", text}); }

class PilotProcesses : public ::testing::Test {
 protected:
  fs::path dir = fs::temp_directory_path() / ("granary_pilot_" + std::to_string(getpid()));
  Machine machine = *local_machine();
  RealLoop loop;
  std::optional<LocalLauncher> launcher;
  std::optional<Journal> journal;
  std::unique_ptr<Pilot> pilot;

  void SetUp() override {
    fs::remove_all(dir);
    fs::create_directories(dir);
    launcher.emplace(loop, machine);
    journal = *Journal::open(dir / "journal.jsonl");
    auto opened = Pilot::open({dir, machine}, loop, *launcher, *journal);
    ASSERT_TRUE(opened.has_value()) << opened.error().message;
    pilot = std::move(*opened);
  }
  void TearDown() override {
    pilot.reset();
    launcher.reset();
    journal.reset();
    fs::remove_all(dir);
  }

  TaskListSummary run(const std::vector<TaskSpec>& tasks) {
    const auto summary = run_task_list(tasks, *pilot, loop);
    EXPECT_TRUE(summary.has_value()) << (summary ? "" : summary.error().message);
    return summary ? *summary : TaskListSummary{};
  }
  TaskEnd end_of(const std::string& name) const { return pilot->end(*pilot->find(name)).value_or(TaskEnd{}); }
  std::string output(const std::string& file) const { return read_text(dir / file).value_or("<none>"); }
  int pid_of(const std::string& name) const {
    const json::Value status = pilot->status();
    for (const json::Value& running : status["tasks"].items()) {
      if (running.text_or("name", "") == name) return static_cast<int>(running.integer_or("pid", 0));
    }
    return 0;
  }
};

/// One field of /proc/PID/status; "" if the process is gone.
std::string process_status(int pid, const std::string& field) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(field + ":")) return line.substr(line.find_first_not_of(" \t", field.size() + 1));
  }
  return "";
}

/// A zombie waits only for its parent (init, for an orphan) to notice.
bool is_alive(int pid) {
  const std::string state = process_status(pid, "State");
  return !state.empty() && state[0] != 'Z';
}

/// Or will be as soon as it gets a core, which takes a filler long on a busy machine: SIGSTOP waits for it.
bool is_stopped(int pid) {
  const std::string pending = process_status(pid, "ShdPnd");
  return process_status(pid, "State").starts_with("T") ||
         (!pending.empty() && (std::stoull(pending, nullptr, 16) >> (SIGSTOP - 1) & 1U) != 0);
}

/// Runs the loop until `done` (looked at every 5 ms) or 10 s are over.
void run_until(RealLoop& loop, const std::function<bool()>& done) {
  const double deadline = loop.now() + 10.0;
  std::function<void()> look = [&] {
    if (done() || loop.now() > deadline) return loop.stop();
    loop.after(0.005, look);
  };
  loop.post(look);
  loop.run();
}

TEST_F(PilotProcesses, PassesArgumentsExactlyAsTheyAre) {
  run({task("args", {"printf", "[%s]", "a b", "it's", "\"q\"", "$HOME", "*", "", "back\\slash", "line\nbreak"})});

  EXPECT_EQ(output("args.out"), "[a b][it's][\"q\"][$HOME][*][][back\\slash][line\nbreak]");
}

TEST_F(PilotProcesses, PinsEachTaskToItsCoresAndTellsItItsThreads) {
  std::vector<TaskSpec> tasks;
  for (int k = 0; k < 4; ++k)
    tasks.push_back(
        script("pin" + std::to_string(k), "grep Cpus_allowed_list /proc/self/status; echo $OMP_NUM_THREADS"));
  run(tasks);

  for (const TaskSpec& spec : tasks) {
    const int cpu = machine.cpu_of(end_of(spec.name).cores.front());
    EXPECT_EQ(output(spec.name + ".out"), "Cpus_allowed_list:\t" + std::to_string(cpu) + "\n1\n");
  }
}

TEST_F(PilotProcesses, WorksInTheTasksFolderAndKeepsItsOutputThere) {
  TaskSpec spec = script("where", "pwd; echo oops >&2; ls -l /proc/self/fd | wc -l");
  spec.dir = "runs/where";
  spec.stderr_file = "err.txt";
  spec.env = {{"GREETING", "hello"}};
  run({spec});

  EXPECT_THAT(output("runs/where/where.out"), HasSubstr((dir / "runs/where").string() + "\n"));
  EXPECT_EQ(output("runs/where/err.txt"), "oops\n");
  EXPECT_THAT(output("runs/where/where.out"), HasSubstr("\n5\n"))
      << "0, 1, 2 and the listed folder: no descriptor of ours is left open";
}

// The files of all but the first few are made before their tasks are known, and named when they start.
TEST_F(PilotProcesses, MakesOutputFilesThatAreLikeAnyOthersAndEmptiesThoseThatAreThere) {
  ASSERT_TRUE(write_text_atomically(dir / "t7.out", "a long line of somebody else's\n").has_value());
  fs::create_symlink("elsewhere", dir / "t9.out");
  std::ofstream(dir / "usual") << "made by open()";
  std::vector<TaskSpec> tasks;
  for (int k = 0; k < 12; ++k) tasks.push_back(script("t" + std::to_string(k), "echo $GRANARY_TASK; echo twice >&2"));

  run(tasks);

  for (const TaskSpec& task : tasks) {
    const fs::path file = dir / (task.name + ".out");
    EXPECT_EQ(output(file.filename()), task.name + "\ntwice\n");
    EXPECT_EQ(fs::status(file).permissions(), fs::status(dir / "usual").permissions()) << task.name;
    EXPECT_EQ(fs::hard_link_count(file), 1U) << task.name;
  }
  EXPECT_TRUE(fs::is_symlink(dir / "t9.out")) << "what leads elsewhere is followed";
  const auto files = std::distance(fs::directory_iterator(dir), fs::directory_iterator());
  EXPECT_EQ(files, 12 + 3) << "12 outputs, one of them elsewhere, \"usual\" and the journal; no file was left over";
}

TEST_F(PilotProcesses, FailsAMissingProgramAtOnceAndNamesThePathSearched) {
  TaskSpec spec = task("gone", {"no-such-program-here"});
  spec.retries = 3;
  const auto summary = run({spec, task("ok", {"true"})});

  EXPECT_EQ(summary.exit, Exit::task_failed);
  EXPECT_EQ(summary.finished, 1);
  EXPECT_THAT(end_of("gone").reason, HasSubstr("no-such-program-here: no such program in PATH ("));
  EXPECT_EQ(end_of("gone").attempt, 1);
  EXPECT_FALSE(fs::exists(dir / "gone.out"));
}

TEST_F(PilotProcesses, ReportsExitCodesAndSignals) {
  run({script("seven", "exit 7"), script("segv", "kill -SEGV $$")});

  EXPECT_EQ(end_of("seven").exit_code, 7);
  EXPECT_EQ(end_of("seven").reason, "exit code 7");
  EXPECT_EQ(end_of("segv").signal, SIGSEGV);
  EXPECT_THAT(end_of("segv").reason, HasSubstr("signal 11"));
}

TEST_F(PilotProcesses, KeepsTheFilesOfEveryAttempt) {
  TaskSpec spec = script("try",
                         "echo $GRANARY_ATTEMPT; sleep 0.02; echo $GRANARY_ATTEMPT > made; echo $GRANARY_ATTEMPT > "
                         "other; test $GRANARY_ATTEMPT = 3");
  spec.dir = "own";
  spec.retries = 2;
  spec.produces = {"made"};
  fs::create_directories(dir / "own");
  std::ofstream(dir / "own/input") << "kept";
  run({spec});

  EXPECT_EQ(end_of("try").state, TaskState::finished) << end_of("try").reason;
  EXPECT_EQ(end_of("try").attempt, 3);
  EXPECT_EQ(output("own/try.attempt-1/try.out"), "1\n");
  EXPECT_EQ(output("own/try.attempt-1/made"), "1\n");
  EXPECT_EQ(output("own/try.attempt-2/made"), "2\n");
  EXPECT_EQ(output("own/try.out"), "3\n");
  EXPECT_EQ(output("own/input"), "kept");
  EXPECT_EQ(output("own/try.attempt-1/other"), "1\n") << "written by the attempt in a folder of its own";
}

TEST_F(PilotProcesses, FailsATaskThatDidNotProduceWhatItShould) {
  TaskSpec spec = script("lazy", "true");
  spec.produces = {"result.h5"};
  run({spec});

  EXPECT_EQ(end_of("lazy").state, TaskState::failed);
  EXPECT_THAT(end_of("lazy").reason, HasSubstr("did not produce result.h5"));
}

TEST_F(PilotProcesses, EndsATaskAtItsTimeout) {
  TaskSpec spec = task("long", {"sleep", "60"});
  spec.timeout = 0.3;
  run({spec});

  EXPECT_EQ(end_of("long").state, TaskState::failed);
  EXPECT_THAT(end_of("long").reason, HasSubstr("timeout of 0.3 s"));
  EXPECT_NEAR(end_of("long").end - end_of("long").start, 0.3, 0.25);
}

TEST_F(PilotProcesses, StopsGracefullyWithinTheGraceTimeAndKillsAfterIt) {
  TaskSpec deaf = script("deaf", "trap '' TERM; echo up; while :; do sleep 0.05; done");
  deaf.stop.grace = 0.4;
  const TaskId good_id =
      *pilot->submit(script("good", "trap 'echo bye; exit 0' TERM; echo up; while :; do sleep 0.05; done"));
  const TaskId deaf_id = *pilot->submit(deaf);
  run_until(loop, [&] { return output("good.out") == "up\n" && output("deaf.out") == "up\n"; });
  const double asked = pilot->now();
  pilot->stop(good_id, "enough");
  pilot->stop(deaf_id, "enough");
  run_until(loop, [&] { return pilot->idle(); });

  EXPECT_THAT(output("good.out"), HasSubstr("bye\n"));
  EXPECT_EQ(end_of("good").state, TaskState::stopped);
  EXPECT_EQ(end_of("good").exit_code, 0);
  EXPECT_LT(end_of("good").end - asked, 0.4);
  EXPECT_EQ(end_of("deaf").signal, SIGKILL);
  EXPECT_GE(end_of("deaf").end - asked, 0.4);
  EXPECT_LT(end_of("deaf").end - asked, 2.0);
}

TEST_F(PilotProcesses, LeavesNoProcessBehindWhenATaskIsKilled) {
  // A child in a session of its own, as a daemon or an MPI rank would be.
  const TaskId id = *pilot->submit(script(
      "family", "setsid sh -c 'echo $$ > daemon; exec sleep 60' & echo $$ > leader; trap '' TERM; wait; sleep 60"));
  run_until(loop, [&] {
    return output("daemon").size() > 1 && output("daemon") != "<none>" && output("leader") != "<none>";
  });
  const int daemon = std::stoi(output("daemon"));
  ASSERT_TRUE(is_alive(daemon));
  launcher->kill({id, 1});
  run_until(loop, [&] { return pilot->idle(); });

  EXPECT_FALSE(is_alive(daemon));
  EXPECT_EQ(end_of("family").state, TaskState::failed);
}

TEST_F(PilotProcesses, SuspendsAFillerWhileATaskNeedsItsCoreAndResumesIt) {
  for (int k = 0; k < machine.n_cores(); ++k) {
    TaskSpec filler = script("fill" + std::to_string(k), "exec sleep 1");
    filler.fill = true;
    ASSERT_TRUE(pilot->submit(filler).has_value());
  }
  run_until(loop, [&] { return process_status(pid_of("fill0"), "Name") == "sleep"; });
  const int pid = pid_of("fill0");
  TaskSpec urgent = script("urgent", "sleep 0.4");
  urgent.threads = machine.n_cores();
  const TaskId id = *pilot->submit(urgent);
  run_until(loop, [&] { return pilot->state(id) == TaskState::running; });

  EXPECT_TRUE(is_stopped(pid));
  EXPECT_EQ(pilot->state(*pilot->find("fill0")), TaskState::suspended);
  run_until(loop, [&] {
    return pilot->state(id) == TaskState::finished && pilot->state(*pilot->find("fill0")) == TaskState::running;
  });
  EXPECT_FALSE(is_stopped(pid));
  run_until(loop, [&] { return pilot->idle(); });
  EXPECT_EQ(end_of("fill0").state, TaskState::finished);
  EXPECT_EQ(pilot->timeline().at(0).outcome, TaskState::suspended);
}

TEST_F(PilotProcesses, UsesNextToNoCpuWhileItWaits) {
  rusage before = {}, after = {};
  getrusage(RUSAGE_SELF, &before);
  run({task("sleep", {"sleep", "2"})});
  getrusage(RUSAGE_SELF, &after);
  const auto seconds = [](const rusage& u) {
    return static_cast<double>(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
  };

  EXPECT_LT(seconds(after) - seconds(before), 0.01) << "0.5 % of 2 s, start and end included";
  EXPECT_LT(after.ru_nvcsw - before.ru_nvcsw, 60) << "it woke up for nothing";
}

TEST(Spawn, StampsAProcessAsTheKernelDoes) {
  for (int k = 0; k < 40; ++k) {
    const auto process = spawn({"/bin/sleep", {"sleep", "30"}, {}, "", {}});
    ASSERT_TRUE(process.has_value());
    EXPECT_EQ(process->start_ticks, start_ticks(process->pid));
    kill(process->pid, SIGKILL);
    (void)reap(process->pidfd);
    close(process->pidfd);
  }
}

TEST(Spawn, StampsAPreparedProcessAsTheKernelDoesAndTellsWhyItCouldNotStart) {
  PreparedProcesses prepared(2);
  std::optional<Spawned> process;
  const auto start = [&](const std::string& file) {
    process.reset();
    for (int k = 0; k < 2000 && !process; ++k, usleep(1000))
      process = prepared.start({file, {file, "30"}, {}, "/", {}});
    ASSERT_TRUE(process.has_value());
  };

  for (int k = 0; k < 20; ++k) {
    start("/bin/sleep");
    EXPECT_EQ(process->start_ticks, start_ticks(process->pid));
    kill(process->pid, SIGKILL);
    EXPECT_EQ(reap(process->pidfd).signal, SIGKILL);
    EXPECT_FALSE(start_failure(process->child).has_value());
    close(process->pidfd);
  }
  start("/etc/passwd");
  EXPECT_EQ(reap(process->pidfd).exit_code, 127);
  EXPECT_THAT(start_failure(process->child).value().message, HasSubstr("/etc/passwd: cannot be executed: Permission"));
  close(process->pidfd);
}

/// The processes of a program whose parent is this one.
std::vector<int> children_of(int pid) {
  std::vector<int> children;
  for (const auto& thread : fs::directory_iterator("/proc/" + std::to_string(pid) + "/task")) {
    std::ifstream file(thread.path() / "children");
    for (int child = 0; file >> child;) children.push_back(child);
  }
  return children;
}

TEST(Spawn, PreparedProcessesHoldNoFileAndGoWithAPilotThatIsKilled) {
  const fs::path file = fs::temp_directory_path() / ("granary_prepared_" + std::to_string(getpid()));
  std::ofstream held(file);
  const int pilot = fork();
  if (pilot == 0) {
    PreparedProcesses prepared(3);
    while (true) pause();
  }
  std::vector<int> waiting;
  for (int k = 0; k < 5000 && waiting.size() < 3; ++k, usleep(1000)) waiting = children_of(pilot);
  ASSERT_EQ(waiting.size(), 3u);
  usleep(50'000);
  for (const int pid : waiting) {
    std::vector<std::string> open;
    for (const auto& fd : fs::directory_iterator("/proc/" + std::to_string(pid) + "/fd"))
      open.push_back(fs::read_symlink(fd.path()).string());
    EXPECT_THAT(open, ElementsAre("/dev/null", "/dev/null", "/dev/null"));
  }
  kill(pilot, SIGKILL);
  waitpid(pilot, nullptr, 0);

  const auto lives = [](int pid) { return kill(pid, 0) == 0 && process_status(pid, "State").substr(0, 1) != "Z"; };
  for (int k = 0; k < 2000 && std::any_of(waiting.begin(), waiting.end(), lives); ++k) usleep(1000);
  EXPECT_TRUE(std::none_of(waiting.begin(), waiting.end(), lives));
  fs::remove(file);
}

TEST(RunProgram, GivesInputAndTakesBothOutputs) {
  const auto output = run_program({"/bin/sh", "-c", "cat; echo problem >&2; exit 3"}, "some\ninput", 10.0);

  ASSERT_TRUE(output.has_value()) << output.error().message;
  EXPECT_EQ(output->out, "some\ninput");
  EXPECT_EQ(output->err, "problem\n");
  EXPECT_EQ(output->exit_code, 3);
}

TEST(RunProgram, TakesMoreThanAPipeHolds) {
  const auto output = run_program({"cat"}, std::string(3'000'000, 'x'), 10.0);

  ASSERT_TRUE(output.has_value());
  EXPECT_EQ(output->out.size(), 3'000'000u);
}

TEST(RunProgram, EndsWhatRunsTooLongAndRefusesWhatIsMissing) {
  EXPECT_THAT(run_program({"sleep", "60"}, "", 0.2).error().message, HasSubstr("still ran after 0.2 s"));
  EXPECT_THAT(run_program({"no-such-program"}, "", 1.0).error().message, HasSubstr("no such program in PATH"));
}

}  // namespace
}  // namespace granary::pilot
