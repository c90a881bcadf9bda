// Error against CPU time, for the solver and for the plain reference.
#pragma once

#include "common/json/value.hpp"
#include "pbm_solver/bench/effort.hpp"

namespace granary::pbm::bench {

/// aggregation_case() on several grids and with several tolerances (ours) and step limits (the reference); the error
/// is that of the numbers against the exact solution at the end, sum |N - exact| / sum exact over the cells: space and
/// time together. Runs that do not fit into the budget are named in `left_out`, not guessed.
/// @return  {work_precision[], speedup_at_error[], work_precision_left_out[]}; docs/bench.md has the members
json::Value work_precision(Effort effort);

}  // namespace granary::pbm::bench
