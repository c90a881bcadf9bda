#include "controller/bench/dem_run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <future>
#include <sstream>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "dem_templates/render/deck.hpp"
#include "pilot/launch/command.hpp"
#include "pilot/launch/run_program.hpp"
#include "pilot/schedule/machine.hpp"

extern char** environ;

namespace granary::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kTimeout = 7200.0;  // [s]

/// `mpirun` as the pilot calls it: ranks pinned to cores of their own.
Result<std::vector<std::string>> with_ranks(const std::vector<std::string>& command, const fs::path& folder,
                                            int ranks) {
  GRANARY_TRY(const pilot::Machine machine, pilot::local_machine());
  pilot::Launch launch;
  launch.spec.command = command;
  launch.spec.ranks = ranks;
  launch.spec.mpi = true;
  launch.cores.add(0, ranks);
  const fs::path rank_file = folder / "ranks";
  GRANARY_CHECK(write_text_atomically(rank_file, pilot::rank_file_text(launch, machine)));
  std::vector<std::string> env;
  for (char** entry = environ; *entry != nullptr; ++entry) env.emplace_back(*entry);
  return pilot::mpirun_argv(launch, env, rank_file, geteuid() == 0);
}

}  // namespace

std::vector<Loop> read_loops(const std::string& printed) {
  std::vector<Loop> loops;
  std::istringstream lines(printed);
  for (std::string line; std::getline(lines, line);) {
    Loop loop;
    int ranks = 0;
    double pair = 0.0;
    if (std::sscanf(line.c_str(), "Loop time of %lf on %d procs for %ld steps with %ld atoms", &loop.seconds, &ranks,
                    &loop.steps, &loop.particles) == 4)
      loops.push_back(loop);
    else if (!loops.empty() && std::sscanf(line.c_str(), "Pair  time (%%) = %lf", &pair) == 1)
      loops.back().pair_seconds = pair;
  }
  return loops;
}

double load_of_machine() {
  double one = 0.0;
  return getloadavg(&one, 1) == 1 ? one : -1.0;
}

std::string granary_dem() {
  const fs::path beside = program_folder() / "granary-dem";
  // Tests lie in a folder beside that of the programs.
  return (fs::exists(beside) ? beside : program_folder().parent_path() / "bin" / "granary-dem").string();
}

Result<DemRun> run_dem(const std::string& program, const fs::path& folder, const std::string& input, int ranks) {
  std::vector<std::string> argv{program, "-in", input, "-log", "none"};
  if (ranks > 1) {
    GRANARY_TRY(argv, with_ranks(argv, folder, ranks));
  }
  // It ends with this program, however that ends: mpirun is asked, so that it takes its ranks along.
  argv.insert(argv.begin(), {"setpriv", "--pdeathsig", ranks > 1 ? "TERM" : "KILL", "env", "-C", folder.string()});
  const auto begin = std::chrono::steady_clock::now();
  GRANARY_TRY(pilot::ProgramOutput ended, pilot::run_program(argv, "", kTimeout));
  DemRun run;
  run.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (ended.exit_code != 0) {
    // LIGGGHTS says what is wrong on stdout, MPI that something is on stderr.
    const std::string said =
        ended.out.substr(ended.out.size() - std::min<std::size_t>(ended.out.size(), 600)) + ended.err.substr(0, 600);
    return Error{fmt::format("{} in {} ended with exit code {} (signal {}): {}", program, folder.string(),
                             ended.exit_code, ended.signal, said),
                 Exit::task_failed};
  }
  run.loops = read_loops(ended.out);
  run.printed = std::move(ended.out);
  return run;
}

Result<Burst> run_burst(const dem::DemCase& c, const fs::path& folder, const std::string& more) {
  GRANARY_CHECK(dem::write_burst(c, folder));
  if (!more.empty()) std::ofstream(folder / "in.liggghts", std::ios::app) << more;
  Burst burst;
  GRANARY_TRY(burst.run, run_dem(granary_dem(), folder, "in.liggghts", c.ranks));
  GRANARY_TRY(burst.tallies, json::read_lines(folder / "tallies.jsonl"));
  if (burst.tallies.size() < 2)
    return Error{fmt::format("{}: no window was measured.", (folder / "tallies.jsonl").string()), Exit::task_failed};
  return burst;
}

Status at_once(std::size_t n, const std::function<Status(std::size_t)>& work) {
  const auto machine = pilot::local_machine();
  const std::size_t workers = machine ? static_cast<std::size_t>(std::max(1, machine->n_cores())) : 1;
  std::atomic<std::size_t> next{0};
  std::vector<std::future<Status>> all;
  for (std::size_t w = 0; w < std::min(workers, n); ++w)
    all.push_back(std::async(std::launch::async, [&]() -> Status {
      for (std::size_t k = next++; k < n; k = next++)
        if (Status done = work(k); !done) {
          next = n;
          return done;
        }
      return {};
    }));
  Status first;
  for (auto& one : all)
    if (Status done = one.get(); !done && first) first = done;
  return first;
}

}  // namespace granary::bench
