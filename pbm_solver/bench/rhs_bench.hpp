// Time of one right-hand side: the solver and the plain reference side by side.
#pragma once

#include "common/json/value.hpp"
#include "pbm_solver/bench/effort.hpp"

namespace granary::pbm::bench {

/// operator_case() on the grids of the bench (bins x bins x compartments): tables of 8 and 16 DEM classes, the constant
/// kernel, and the Stokes efficiency (ours alone). One thread each, medians of thread CPU time, in turn.
/// @return  {rhs[]}: grid, classes, kernel, cores, solver_s, reference_s, ratio, reference_how, and the same
///          with bisection, bisecting_reference_s, ratio_to_bisecting; with the Stokes
///          efficiency kernel_refresh_s too, what a run adds whenever liquid or sizes have moved
json::Value rhs_timings(Effort effort);

}  // namespace granary::pbm::bench
