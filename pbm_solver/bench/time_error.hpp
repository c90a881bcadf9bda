// How many right-hand sides the time integration needs for its own error, apart from the grid's.
#pragma once

#include "common/json/value.hpp"
#include "pbm_solver/bench/effort.hpp"

namespace granary::pbm::bench {

/// Runs at several tolerances against a run on the same grid at a far smaller one: aggregation_case() on 32 x 32
/// classes, and two stiff_case()s. The error is that at the end; of
/// the stiff cases, which are at rest by then, the largest at four times on the way too. For the first also the
/// reference's explicit Euler.
/// @return  {temporal[]}: case, its runs, and the right-hand sides for a temporal error of 1e-3
json::Value time_errors(Effort effort);

/// published_case() at its usual tolerance, timed on one thread, with its temporal error against a run at a hundredth
/// of that tolerance.
/// @return  {published_case{}}
json::Value published_run(Effort effort);

}  // namespace granary::pbm::bench
