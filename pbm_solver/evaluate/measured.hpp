// What an instrument would have read off a state: the model's side of a target.
#pragma once

#include <vector>

#include "estimation/problem/target.hpp"
#include "pbm_solver/model/class_grid.hpp"
#include "pbm_solver/time/snapshot.hpp"

namespace granary::pbm {

/// The target's quantity in its compartment(s), SI: one number, or the shares of a distribution. Without particles: 0.
std::vector<double> measured(const estimation::Target& target, const Snapshot& state, const PbmCase& pbm_case,
                             const ClassGrid& grid);

}  // namespace granary::pbm
