#include "controller/bench/pilot_simulation.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "common/json/problems.hpp"
#include "controller/bench/stopwatch.hpp"
#include "pilot/launch/simulated_launcher.hpp"
#include "pilot/loop/virtual_loop.hpp"
#include "pilot/pilot.hpp"

namespace granary::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kNodeMemory = 256LL << 30;
constexpr double kShortest = 0.1, kLongest = 3600.0;  ///< [s]
constexpr int kMostRanks = 4096;

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Resident memory now [bytes].
double resident() {
  std::ifstream file("/proc/self/statm");
  double pages = 0.0, resident = 0.0;
  file >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// Independent draws for each task, from its number alone: a load needs no memory. (SplitMix64.)
class Draws {
 public:
  Draws(int task, int stream) : state_(static_cast<std::uint64_t>(task) << 8U | static_cast<unsigned>(stream)) {}
  /// In [0, 1).
  double next() {
    std::uint64_t x = state_ += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
    return static_cast<double>((x ^ (x >> 31U)) >> 11U) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

/// The mixed load.
class Load {
 public:
  explicit Load(const SimulationSize& size) : most_ranks_(std::min(kMostRanks, size.nodes * size.cores)) {}

  pilot::TaskSpec task(int k) const {
    Draws draws(k, 1);
    pilot::TaskSpec spec;
    spec.name = fmt::format("t{}", k);
    spec.command = {"simulated"};
    if (draws.next() < 0.3) spec.ranks = std::min(most_ranks_, log_uniform(draws.next(), 2, kMostRanks));
    if (draws.next() < 0.8) spec.expected = seconds(k) * (1.0 + draws.next());
    if (draws.next() < 0.1) spec.memory_bytes = static_cast<std::int64_t>(spec.ranks) << (30 + k % 3);
    if (draws.next() < 0.05) spec.priority = 1;
    if (k > 0 && draws.next() < 0.05) spec.after = {fmt::format("t{}", k / 2)};
    return spec;
  }
  double seconds(int k) const { return kShortest * std::pow(kLongest / kShortest, Draws(k, 2).next()); }

 private:
  static int log_uniform(double share, int low, int high) {
    return static_cast<int>(std::lround(low * std::pow(static_cast<double>(high) / low, share)));
  }
  int most_ranks_;
};

int number_of(const pilot::TaskSpec& spec) { return std::stoi(spec.name.substr(1)); }

/// No schedule is shorter: the work on all cores, or the longest chain of tasks that wait for each other [s].
double lower_bound(const Load& load, const SimulationSize& size) {
  double work = 0.0, longest = 0.0;
  std::vector<float> ends(static_cast<std::size_t>(size.tasks), 0.0F);
  for (int k = 0; k < size.tasks; ++k) {
    const pilot::TaskSpec spec = load.task(k);
    const double seconds = load.seconds(k);
    work += seconds * spec.cores();
    const double before = spec.after.empty() ? 0.0 : static_cast<double>(ends[static_cast<std::size_t>(k / 2)]);
    ends[static_cast<std::size_t>(k)] = static_cast<float>(before + seconds);
    longest = std::max(longest, before + seconds);
  }
  return std::max(longest, work / size.nodes / size.cores);
}

}  // namespace

Result<SimulationRun> simulate_pilot(const SimulationSize& size, const fs::path& dir) {
  const Load load(size);
  SimulationRun run;
  run.size = size;
  run.lower_bound = lower_bound(load, size);
  std::error_code ignored;
  const fs::path file = dir / "journal.jsonl";
  fs::remove(file, ignored);
  malloc_trim(0);

  pilot::VirtualLoop loop;
  pilot::SimulatedLauncher launcher(
      loop, [&](const pilot::TaskSpec& spec) { return pilot::SimulatedRun{load.seconds(number_of(spec))}; });
  GRANARY_TRY(pilot::Journal journal, pilot::Journal::open(file, [&] { return loop.wall_time(); }));
  const pilot::Machine machine = pilot::stated_machine(size.nodes, size.cores, kNodeMemory);
  GRANARY_TRY(const auto pilot,
              pilot::Pilot::open({.dir = dir, .machine = machine, .sync_every = 0.0}, loop, launcher, journal));
  const double resident_before = resident();

  const auto begin = Clock::now();
  const double cpu_begin = cpu_seconds();
  for (int k = 0; k < size.tasks; ++k) {
    GRANARY_TRY(const pilot::TaskId id, pilot->submit(load.task(k)));
    (void)id;
  }
  run.submit_s = seconds_since(begin);
  double resident_most = resident();
  int ended = 0;
  pilot->on_end([&](const pilot::TaskEnd& end) {
    run.finished += end.state == pilot::TaskState::finished;
    if (++ended % 4096 == 0) resident_most = std::max(resident_most, resident());
  });
  pilot->on_idle([&] { loop.stop(); });
  const auto started = Clock::now();
  loop.run();
  run.run_s = seconds_since(started);
  run.cpu_s = cpu_seconds() - cpu_begin;
  resident_most = std::max(resident_most, resident());
  if (pilot->failure()) return *pilot->failure();
  run.bytes_per_task = std::max(0.0, resident_most - resident_before) / size.tasks;
  run.makespan = pilot->now();
  const pilot::Usage usage = pilot->usage();
  run.core_use = usage.total > 0.0 ? usage.busy / usage.total : 0.0;
  run.journal_bytes = static_cast<double>(fs::file_size(file, ignored));
  fs::remove(file, ignored);
  return run;
}

Result<SimulationRun> simulate_pilot_steadily(const SimulationSize& size, const fs::path& dir) {
  const std::size_t times = size.tasks <= 1000 ? 9 : size.tasks <= 10'000 ? 5 : size.tasks <= 100'000 ? 3 : 1;
  std::vector<SimulationRun> runs;
  while (runs.size() < times) {
    GRANARY_TRY(const SimulationRun run, simulate_pilot(size, dir));
    runs.push_back(run);
  }
  std::sort(runs.begin(), runs.end(), [](const auto& a, const auto& b) { return a.cpu_s < b.cpu_s; });
  return runs[times / 2];
}

Result<SimulationSize> parse_simulation_size(const std::string& text) {
  SimulationSize size;
  const std::map<std::string, std::pair<int*, int>> keys{
      {"nodes", {&size.nodes, 100'000}}, {"cores", {&size.cores, 1024}}, {"tasks", {&size.tasks, 10'000'000}}};
  const auto wrong = [&](const std::string& what) {
    return Error{fmt::format("--simulate \"{}\": {} Write nodes=10000,cores=64,tasks=1000000.", text, what)};
  };
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::size_t equals = std::min(part.find('='), part.size());
    const auto found = keys.find(part.substr(0, equals));
    if (found == keys.end()) return wrong(fmt::format("\"{}\" is none of nodes=, cores=, tasks=.", part));
    const std::string digits = part.substr(std::min(equals + 1, part.size()));
    const bool good =
        !digits.empty() && digits.size() < 9 && digits.find_first_not_of("0123456789") == std::string::npos;
    const int value = good ? std::stoi(digits) : 0;
    if (value < 1 || value > found->second.second)
      return wrong(fmt::format("{} must be a number from 1 to {}.", found->first, found->second.second));
    *found->second.first = value;
    begin = end + 1;
  }
  for (const auto& [key, target] : keys) {
    if (*target.first == 0) return wrong(fmt::format("{} is missing.", key));
  }
  return size;
}

}  // namespace granary::bench
