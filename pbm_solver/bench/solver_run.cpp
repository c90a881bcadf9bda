#include "pbm_solver/bench/solver_run.hpp"

#include <vector>

#include "common/math/percentile.hpp"
#include "pbm_solver/bench/measure.hpp"
#include "pbm_solver/time/simulation.hpp"

namespace granary::pbm::bench {
namespace {

constexpr int kRepeats = 5;
constexpr double kLongEnough = 0.1;  // [s]

Result<SolverRun> run_once(const BenchCase& b, double most_cpu, const std::vector<double>& looks) {
  Alone alone(b.pbm_case.compartments.count);
  SolverRun run;
  const double began = thread_cpu();
  Simulation simulation(b.pbm_case, b.start, alone, 1);
  const auto in_budget = [&] { return thread_cpu() - began < most_cpu; };
  for (const double time : looks) {
    GRANARY_TRY(const bool reached, simulation.advance(time, in_budget));
    if (!reached) return run;
    run.looks.push_back(simulation.snapshot());
  }
  GRANARY_TRY(run.finished, simulation.advance(b.pbm_case.end_time, in_budget));
  run.cpu = thread_cpu() - began;
  run.work = simulation.work();
  run.end = simulation.snapshot();
  return run;
}

}  // namespace

Result<SolverRun> run_solver(const BenchCase& b, double most_cpu, const std::vector<double>& looks) {
  GRANARY_TRY(SolverRun run, run_once(b, most_cpu, looks));
  std::vector<double> cpu{run.cpu};
  while (run.cpu < kLongEnough && cpu.size() < kRepeats) {
    GRANARY_TRY(const SolverRun again, run_once(b, most_cpu, looks));
    cpu.push_back(again.cpu);
  }
  run.cpu = median(cpu);
  return run;
}

}  // namespace granary::pbm::bench
