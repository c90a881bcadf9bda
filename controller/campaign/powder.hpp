// A powder as shares of particles over the classes of a grid: what is fed, and what a batch starts from.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "pbm_solver/case/pbm_case.hpp"

namespace granary::campaign {

/// Pivot i (from 0) of component k [m^3].
double pivot(const pbm::Grid& grid, int k, int i);

/// Mass of the solids in these particles [kg] (or [kg/s] where the rates are per time).
double solid_mass(const std::vector<pbm::ClassRate>& classes, const pbm::Grid& grid, const pbm::Materials& materials);

/// The feed of the published CM5 cases, in particles/s: nine classes of 12 to 232 um with as much of either solid,
/// together 15 kg/h at 476 kg/m^3. It is given as volumes; on a grid that has no pivot there a class is shared between
/// the pivots around it, so that particles and both solids are kept. Errors: the grid does not reach over all of it.
/// Source: parameters of the public code of the parallel unidirectional DEM-PBM paper (Sampat et al. 2018).
Result<std::vector<pbm::ClassRate>> published_feed(const pbm::Grid& grid);

}  // namespace granary::campaign
