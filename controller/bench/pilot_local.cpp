#include "controller/bench/pilot_local.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <thread>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "common/math/percentile.hpp"
#include "controller/bench/stopwatch.hpp"
#include "pilot/launch/command.hpp"
#include "pilot/launch/local_launcher.hpp"
#include "pilot/launch/simulated_launcher.hpp"
#include "pilot/launch/spawn.hpp"
#include "pilot/launch/spawn_limit.hpp"
#include "pilot/loop/virtual_loop.hpp"
#include "pilot/pilot.hpp"

extern char** environ;

namespace granary::bench {
namespace {

namespace fs = std::filesystem;
using json::Value;
using pilot::TaskEnd;
using pilot::TaskSpec;

/// A pilot of our own on real cores, journal on, as `granary run` has it.
struct Site {
  pilot::Machine machine;
  pilot::RealLoop loop;
  pilot::LocalLauncher launcher{loop, machine};
  std::unique_ptr<pilot::Journal> journal;
  std::unique_ptr<pilot::Pilot> pilot;

  explicit Site(pilot::Machine cores) : machine(std::move(cores)) {}

  static Result<std::unique_ptr<Site>> open(const fs::path& dir, pilot::Machine machine) {
    GRANARY_CHECK(make_folders(dir));
    auto site = std::make_unique<Site>(std::move(machine));
    GRANARY_TRY(pilot::Journal journal, pilot::Journal::open(dir / "journal.jsonl"));
    site->journal = std::make_unique<pilot::Journal>(std::move(journal));
    GRANARY_TRY(site->pilot, pilot::Pilot::open({dir, site->machine}, site->loop, site->launcher, *site->journal));
    site->pilot->on_idle([loop = &site->loop] { loop->stop(); });
    return site;
  }
  /// Queues the tasks and runs them to their end; seconds. Error: one of them did not finish.
  Result<double> run(const std::vector<TaskSpec>& tasks) {
    const auto begin = Clock::now();
    for (const TaskSpec& task : tasks) {
      GRANARY_TRY(const pilot::TaskId id, pilot->submit(task));
      (void)id;
    }
    if (!pilot->idle()) loop.run();
    const double seconds = seconds_since(begin);
    if (pilot->failure()) return *pilot->failure();
    for (const TaskSpec& task : tasks) {
      const auto end = pilot->end(*pilot->find(task.name));
      if (!end || end->state != pilot::TaskState::finished)
        return Error{
            fmt::format("the bench's task {} did not finish: {}", task.name, end ? end->reason : "it is lost")};
    }
    return seconds;
  }
};

std::vector<TaskSpec> tasks_named(const std::string& prefix, int count, const std::vector<std::string>& command) {
  std::vector<TaskSpec> tasks;
  for (int k = 0; k < count; ++k) {
    TaskSpec task;
    task.name = fmt::format("{}{}", prefix, k);
    task.command = command;
    tasks.push_back(std::move(task));
  }
  return tasks;
}

class Bench {
 public:
  Bench(const LocalBench& bench, pilot::Machine machine, const std::function<void(const std::string&)>& say)
      : bench_(bench), machine_(std::move(machine)), say_(say) {}

  Result<Value> run() {
    figures_.set("cores", machine_.n_cores());
    GRANARY_CHECK(throughput());
    GRANARY_CHECK(latency());
    GRANARY_CHECK(dispatch());
    GRANARY_CHECK(core_use());
    GRANARY_CHECK(fillers());
    GRANARY_CHECK(startup());
    GRANARY_CHECK(idle());
    GRANARY_CHECK(mpi());
    GRANARY_CHECK(resume());
    return std::move(figures_);
  }

 private:
  /// Bare starts and the pilot's by turns, so that both meet the same neighbours.
  Status throughput() {
    constexpr int kRounds = 10;
    const int n = std::max(1, bench_.tasks / kRounds);
    say_(fmt::format("{} tasks of /bin/true, and as many bare starts", kRounds * n));
    const fs::path dir = bench_.dir / "throughput";
    GRANARY_TRY(const auto site, Site::open(dir, machine_));
    std::vector<double> ours, bare, ratios;
    for (int round = 0; round < kRounds; ++round) {
      GRANARY_TRY(const double limit, pilot::bare_spawn_seconds({"/bin/true"}, n, machine_.n_cores()));
      GRANARY_TRY(const double seconds, site->run(tasks_named(fmt::format("t{}-", round), n, {"/bin/true"})));
      bare.push_back(n / limit);
      ours.push_back(n / seconds);
      ratios.push_back(limit / seconds);
    }
    figures_.set("tasks", kRounds * n)
        .set("throughput_per_s", median(ours))
        .set("spawn_limit_per_s", median(bare))
        .set("ratio", median(ratios));
    std::error_code ignored;
    const auto files = std::distance(fs::directory_iterator(dir, ignored), fs::directory_iterator());
    // The journal is the campaign's, not a task's.
    figures_.set("files_per_task", static_cast<double>(files - 1) / (kRounds * n));
    return {};
  }

  Status latency() {
    constexpr int kTimes = 200;
    say_("one task at a time: submit to done");
    GRANARY_TRY(const auto site, Site::open(bench_.dir / "latency", machine_));
    std::vector<double> times;
    for (const TaskSpec& task : tasks_named("t", kTimes, {"/bin/true"})) {
      GRANARY_TRY(const double seconds, site->run({task}));
      times.push_back(1e3 * seconds);
    }
    GRANARY_TRY(const double bare, pilot::bare_spawn_seconds({"/bin/true"}, kTimes, 1));
    figures_.set("submit_to_done_ms", median(times)).set("bare_start_to_done_ms", 1e3 * bare / kTimes);
    return {};
  }

  /// From the last thing a task does to the first thing the next one on its core does.
  Status dispatch() {
    constexpr int kTimes = 1000;
    say_("dispatch: a core freed to the next program on it");
    const fs::path dir = bench_.dir / "dispatch";
    GRANARY_TRY(const auto site, Site::open(dir, machine_));
    const auto tasks = tasks_named("t", kTimes, {stamp(), "0.002"});
    GRANARY_TRY(const double seconds, site->run(tasks));
    (void)seconds;
    struct Stamps {
      double begin = 0.0, end = 0.0;
    };
    std::map<int, std::vector<Stamps>> by_core;
    for (const TaskSpec& task : tasks) {
      Stamps stamps;
      std::ifstream(dir / (task.name + ".out")) >> stamps.begin >> stamps.end;
      by_core[site->pilot->end(*site->pilot->find(task.name))->cores.front()].push_back(stamps);
    }
    std::vector<double> gaps;
    for (auto& [core, stamps] : by_core) {
      std::sort(stamps.begin(), stamps.end(), [](const Stamps& a, const Stamps& b) { return a.begin < b.begin; });
      for (std::size_t k = 1; k < stamps.size(); ++k) gaps.push_back(1e-6 * (stamps[k].begin - stamps[k - 1].end));
    }
    figures_.set("dispatch_ms", Value::object({{"p50", percentile(gaps, 0.5)}, {"p99", percentile(gaps, 0.99)}}));
    return {};
  }

  /// The share of the time that sleeps take as asked for. `/bin/sleep` needs 0.7 ms more to load its libraries, whoever
  /// starts it; a program without any shows what the starting itself costs.
  Status core_use() {
    GRANARY_CHECK(core_use("core_use", "/bin/sleep"));
    return core_use("core_use_static", (program_folder() / "granary-nap").string());
  }

  Status core_use(const std::string& key, const std::string& program) {
    Value ours = Value::object(), bare = Value::object(), prepared = Value::object();
    std::vector<int> cpus;
    for (int core = 0; core < machine_.n_cores(); ++core) cpus.push_back(machine_.cpu_of(core));
    for (const char* seconds : {"0.5", "0.1", "0.01"}) {
      const double each = std::stod(seconds);
      const int n = static_cast<int>(std::lround(bench_.seconds * machine_.n_cores() / each));
      const std::vector<std::string> command{program, seconds};
      say_(fmt::format("{} tasks of `{} {}`", n, fs::path(program).filename().string(), seconds));
      GRANARY_TRY(const auto site, Site::open(bench_.dir / (key + "-" + seconds), machine_));
      GRANARY_TRY(const double wall, site->run(tasks_named("t", n, command)));
      GRANARY_TRY(const double limit, pilot::bare_spawn_seconds(command, n, machine_.n_cores()));
      GRANARY_TRY(const double best, pilot::prepared_spawn_seconds(command, n, cpus));
      ours.set(seconds, n * each / machine_.n_cores() / wall);
      bare.set(seconds, n * each / machine_.n_cores() / limit);
      prepared.set(seconds, n * each / machine_.n_cores() / best);
    }
    figures_.set(key, std::move(ours))
        .set(key + "_of_bare_starts", std::move(bare))
        .set(key + "_of_prepared_starts", std::move(prepared));
    return {};
  }

  /// All cores are fillers'; from a task's submission to its first line.
  Status fillers() {
    constexpr int kTimes = 50;
    say_("a filler gives way to a task that is ready");
    const fs::path dir = bench_.dir / "fillers";
    GRANARY_TRY(const auto site, Site::open(dir, machine_));
    for (TaskSpec filler : tasks_named("filler", machine_.n_cores(), {"/bin/sleep", "600"})) {
      filler.fill = true;
      GRANARY_TRY(const pilot::TaskId id, site->pilot->submit(filler));
      (void)id;
    }
    site->loop.after(0.2, [&] { site->loop.stop(); });
    site->loop.run();
    site->pilot->on_end([&](const TaskEnd& end) {
      if (end.name.starts_with("t")) site->loop.stop();
    });
    std::vector<double> times;
    for (const TaskSpec& task : tasks_named("t", kTimes, {stamp()})) {
      const double begin = std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
      GRANARY_TRY(const pilot::TaskId id, site->pilot->submit(task));
      (void)id;
      site->loop.run();
      double first = 0.0;
      std::ifstream(dir / (task.name + ".out")) >> first;
      times.push_back(1e3 * (1e-9 * first - begin));
    }
    site->pilot->stop_all("the bench is over");
    site->loop.run();
    figures_.set("filler_gives_way_ms",
                 Value::object({{"p50", percentile(times, 0.5)}, {"p99", percentile(times, 0.99)}}));
    return {};
  }

  // --- granary itself, as a user starts it ---

  static std::string stamp() { return (program_folder() / "granary-stamp").string(); }

  Result<pilot::Spawned> start_granary(const fs::path& workflow, const fs::path& dir) const {
    pilot::SpawnRequest request;
    request.file = (program_folder() / "granary").string();
    request.argv = {request.file, "run", workflow.string(), "--dir", dir.string(), "--quiet", "--json"};
    for (char** entry = environ; *entry != nullptr; ++entry) request.env.emplace_back(*entry);
    return pilot::spawn(request);
  }

  Status write_workflow(const fs::path& file, const std::vector<std::string>& command) const {
    const Value task = Value::object({{"name", "t"}, {"command", command}});
    return json::write_file(
        file, Value::object({{"granary", 1}, {"kind", "tasks"}, {"name", "bench"}, {"tasks", json::Array{task}}}));
  }

  Status startup() {
    constexpr int kTimes = 11;
    say_("start-up: `granary run` to its first task's end");
    const fs::path workflow = bench_.dir / "startup.json";
    GRANARY_CHECK(write_workflow(workflow, {stamp()}));
    std::vector<double> times;
    for (int k = 0; k < kTimes; ++k) {
      const fs::path dir = bench_.dir / fmt::format("startup-{}", k);
      const double begin = std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
      GRANARY_TRY(const pilot::Spawned process, start_granary(workflow, dir));
      const int code = pilot::reap(process.pidfd).exit_code;
      close(process.pidfd);
      double first = 0.0, last = 0.0;
      std::ifstream(dir / "t.out") >> first >> last;
      if (code != 0 || last == 0.0) return Error{fmt::format("{}: `granary run` failed", dir.string())};
      times.push_back(1e3 * (1e-9 * last - begin));
    }
    figures_.set("startup_ms", median(times));
    return {};
  }

  static double cpu_seconds_of(int pid) {
    double nanoseconds = 0.0;
    std::ifstream(fmt::format("/proc/{}/schedstat", pid)) >> nanoseconds;
    return 1e-9 * nanoseconds;
  }
  static double resident_mb_of(int pid) {
    double pages = 0.0, resident = 0.0;
    std::ifstream(fmt::format("/proc/{}/statm", pid)) >> pages >> resident;
    return 1e-6 * resident * static_cast<double>(sysconf(_SC_PAGESIZE));
  }

  /// `granary run` while its only task sleeps.
  Status idle() {
    say_("what a pilot costs that has nothing to do");
    const fs::path workflow = bench_.dir / "idle.json", dir = bench_.dir / "idle";
    const double seconds = std::max(1.0, 0.5 * bench_.seconds);
    GRANARY_CHECK(write_workflow(workflow, {"/bin/sleep", fmt::format("{}", seconds + 1.0)}));
    GRANARY_TRY(const pilot::Spawned process, start_granary(workflow, dir));
    std::this_thread::sleep_for(std::chrono::duration<double>(0.7));
    const double before = cpu_seconds_of(process.pid);
    const auto begin = Clock::now();
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds - 0.5));
    const double share = (cpu_seconds_of(process.pid) - before) / seconds_since(begin);
    const double resident = resident_mb_of(process.pid);
    const int code = pilot::reap(process.pidfd).exit_code;
    close(process.pidfd);
    if (code != 0) return Error{fmt::format("{}: `granary run` failed", dir.string())};
    figures_.set("idle", Value::object({{"core_share", share}, {"resident_mb", resident}}));
    return {};
  }

  Status mpi() {
    const char* path = std::getenv("PATH");
    const auto mpirun = pilot::find_executable("mpirun", "", path != nullptr ? path : "");
    if (!mpirun) {
      figures_.set("mpi_ms", Value()).set("mpi_ms_why", mpirun.error().message);
      return {};
    }
    constexpr int kTimes = 7;
    say_("a task of one node with mpirun, and mpirun by itself");
    std::vector<std::string> bare{*mpirun};
    if (geteuid() == 0) bare.emplace_back("--allow-run-as-root");
    // As the launcher starts it: the loopback transport, when no fabric is asked for.
    bare.insert(bare.end(), {"--mca", "pml", "ob1", "--mca", "btl", "self,vader", "-n", "1", "/bin/true"});
    GRANARY_TRY(const auto site, Site::open(bench_.dir / "mpi", machine_));
    std::vector<double> ours, theirs;
    for (TaskSpec task : tasks_named("t", kTimes, {"/bin/true"})) {
      task.mpi = true;
      GRANARY_TRY(const double limit, pilot::bare_spawn_seconds(bare, 1, 1));
      GRANARY_TRY(const double seconds, site->run({task}));
      theirs.push_back(1e3 * limit);
      ours.push_back(1e3 * seconds);
    }
    figures_.set("mpi_ms", Value::object({{"task", median(ours)}, {"bare", median(theirs)}}));
    return {};
  }

  /// A campaign of 100 000 finished tasks whose pilot was killed, and what its next pilot needs to go on.
  Status resume() {
    constexpr int kTasks = 100'000;
    say_(fmt::format("resume with {} finished tasks", kTasks));
    const fs::path dir = bench_.dir / "resume";
    GRANARY_CHECK(make_folders(dir));
    {
      pilot::VirtualLoop loop;
      pilot::SimulatedLauncher launcher(loop, [](const TaskSpec&) { return pilot::SimulatedRun{1.0}; });
      GRANARY_TRY(pilot::Journal journal, pilot::Journal::open(dir / "journal.jsonl"));
      GRANARY_TRY(const auto site,
                  pilot::Pilot::open({.dir = dir, .machine = machine_, .sync_every = 0.0}, loop, launcher, journal));
      for (const TaskSpec& task : tasks_named("t", kTasks, {"/bin/true"})) {
        GRANARY_TRY(const pilot::TaskId id, site->submit(task));
        (void)id;
      }
      loop.run();
    }
    std::error_code ignored;
    Value rows = Value::array();
    for (const char* which : {"first", "second"}) {
      const auto bytes = static_cast<std::int64_t>(fs::file_size(dir / "journal.jsonl", ignored));
      const double resident = resident_mb_of(getpid());
      const auto begin = Clock::now();
      GRANARY_TRY(const auto site, Site::open(dir, machine_));
      const double seconds = seconds_since(begin);
      if (site->pilot->ends().size() != kTasks || !site->pilot->idle())
        return Error{"the resumed campaign does not know all its tasks", Exit::internal};
      rows.push(Value::object({{"which", which},
                               {"seconds", seconds},
                               {"journal_bytes", bytes},
                               {"resident_growth_mb", resident_mb_of(getpid()) - resident}}));
    }
    figures_.set("resume_s", rows.items().front().number_or("seconds", 0.0)).set("resume", std::move(rows));
    return {};
  }

  const LocalBench& bench_;
  pilot::Machine machine_;
  const std::function<void(const std::string&)>& say_;
  Value figures_ = Value::object();
};

}  // namespace

Result<Value> run_local_pilot_bench(const LocalBench& bench, const std::function<void(const std::string&)>& say) {
  GRANARY_TRY(pilot::Machine machine, pilot::local_machine(bench.cores));
  return Bench(bench, std::move(machine), say).run();
}

}  // namespace granary::bench
