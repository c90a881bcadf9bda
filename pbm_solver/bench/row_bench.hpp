// Time per right-hand side of a row of compartments on the threads and ranks that this process was started with.
#pragma once

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "pbm_solver/parallel/communicator.hpp"

namespace granary::pbm::bench {

/// row_case(): first the right-hand side alone, over and over at one state, with the halo and one reduction over the
/// ranks as a step has them; then real runs, step by step, wall time over right-hand sides of each step. Collective.
/// @param seconds  wall time of each of the two
/// @return  {ranks, threads, rhs_alone{least_s, p10_s, median_s, samples}, in_run{the same}}
Result<json::Value> row_timings(const Communicator& ranks, int threads, double seconds);

}  // namespace granary::pbm::bench
