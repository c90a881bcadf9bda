// What "auto" stands for in a burst's settings: chosen for its own particles, and for the speeds measured before it.
#pragma once

#include <array>
#include <optional>

#include "dem_templates/case/dem_case.hpp"

namespace granary::dem {

/// The longest time step that the rules of time_step.hpp allow, with two digits [s].
double automatic_time_step(const DemCase& dem_case);

/// Steps between two looks of the tally: two thirds of the fastest impacts' contact time, so that each is seen.
int automatic_tally_every(const DemCase& dem_case);

/// The softest particles that a hit at the expected impact speed presses in by no more than `overlap` (over the radius,
/// elastic), but never stiffer than they are:
///
///   E* = 15 m v^2 / (16 sqrt(R) (overlap R)^(5/2))     1 / E* = (1 - nu^2) (1 / Y + 1 / Y_wall)
///
/// independent of the particle's size. LIGGGHTS takes no less than 5 MPa.   [Pa]
double automatic_young_modulus(const DemCase& dem_case, double overlap);

/// How so many ranks share the machine: cuts across its axis cost the least contacts, until slices are thinner than
/// four of the largest particles; then the cross-section is cut as well.
std::array<int, 3> automatic_rank_grid(const DemCase& dem_case);

}  // namespace granary::dem
