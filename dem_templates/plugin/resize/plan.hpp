// What to do with each particle so that the state holds a population: who grows, who goes, who comes and where to.
// Pure: the same state, population and seed give the same plan, bit for bit, on every rank.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "dem_templates/plugin/resize/free_space.hpp"
#include "dem_templates/plugin/resize/population.hpp"
#include "dem_templates/plugin/resize/vector3.hpp"

namespace granary::dem {

struct Particle {
  std::int64_t tag = 0;
  Vector3 centre{};
  double diameter = 0.0;  ///< [m]
};

struct ResizeOptions {
  int axis = 0;           ///< 0, 1, 2
  double overlap = 0.02;  ///< what the relaxation may leave, of the smaller radius
  int sweeps = 2000;
  std::uint64_t seed = 1;
};

struct ResizePlan {
  std::vector<Particle> kept;      ///< with their new diameters and places, by tag
  std::vector<Particle> inserted;  ///< tags follow the largest one of before
  std::vector<std::int64_t> removed;

  /// Per compartment.
  struct Count {
    std::size_t before = 0, kept = 0, inserted = 0, removed = 0;
    double volume_before = 0.0, volume = 0.0;  ///< [m^3]
  };
  std::vector<Count> compartments;
  double overlap_before = 0.0;   ///< of the state as it was
  double overlap_resized = 0.0;  ///< with the new sizes, before the relaxation
  double overlap = 0.0;          ///< after it
  int sweeps = 0;
};

/// Overlaps larger than this many times ResizeOptions::overlap after the relaxation mean that it does not fit.
constexpr double kHopeless = 5.0;

/// The existing particles of a compartment are ranked by size and take the new diameters in that order; surplus ones
/// go, evenly over the ranks; missing ones are put at the freest of random places; then overlaps are relaxed. Error:
/// the particles do not fit (Exit::bad_input, names the worst compartment).
Result<ResizePlan> plan_resize(std::vector<Particle> existing, const ResizePopulation& population,
                               const FreeSpace& space, const ResizeOptions& options);

/// For people: one line with asked and got particles and volumes per compartment, and the overlaps.
std::string describe(const ResizePlan& plan, const ResizePopulation& population);

}  // namespace granary::dem
