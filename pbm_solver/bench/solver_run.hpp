// One whole run of the solver, timed, within a budget.
#pragma once

#include <vector>

#include "pbm_solver/bench/bench_cases.hpp"
#include "pbm_solver/time/integrator.hpp"

namespace granary::pbm::bench {

struct SolverRun {
  std::vector<Snapshot> looks;  ///< at the times asked for
  Snapshot end;
  WorkCount work;
  double cpu = 0.0;       ///< of this thread, with the making of its tables; median if repeated [s]
  bool finished = false;  ///< false: `most_cpu` was used up first
};

/// From the case's start to its end, on one thread. Runs that take next to no time are repeated, and the median counts.
/// @param looks  times to stop at and keep the state of, rising, before the end
/// Errors: the solver cannot keep the tolerance.
Result<SolverRun> run_solver(const BenchCase& bench_case, double most_cpu, const std::vector<double>& looks = {});

}  // namespace granary::pbm::bench
