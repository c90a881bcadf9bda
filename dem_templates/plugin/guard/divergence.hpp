// When a DEM run has diverged, and what to tell about it. Pure: no LIGGGHTS, no MPI.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/json/value.hpp"

namespace granary::dem {

/// Beyond these a run has diverged.
struct Bounds {
  double overlap = 0.5;                ///< of a particle's radius ...
  double overlapping_fraction = 0.01;  ///< ... that no larger share of the particles, and no more than one, may exceed
  std::optional<double> energy;        ///< translational kinetic energy of all particles [J]
  double lost_fraction = 0.02;         ///< of all particles that ever were in it
};

/// How the run is doing, over all ranks.
struct Vitals {
  bool finite = true;    ///< all positions and velocities are numbers
  double overlap = 0.0;  ///< largest now, over the particle's radius
  long overlapping = 0;  ///< particles that overlap by more than Bounds::overlap
  long present = 0;
  double energy = 0.0;    ///< [J]
  long lost = 0;          ///< since the start
  long ever_present = 0;  ///< at the start, or inserted since
};

struct Divergence {
  std::string cause;  ///< nan, overlap, energy, lost
  double value = 0.0, bound = 0.0;
  std::string message;                ///< cause, value, bound and what to do
  std::vector<std::string> settings;  ///< JSON pointers of the workflow settings to look at
};

/// The worst cause first: numbers that are none, overlap, energy, losses.
std::optional<Divergence> find_divergence(const Vitals& vitals, const Bounds& bounds);

/// The last line of tallies.jsonl: docs/exchange_formats.md.
json::Value divergence_line(const Divergence& divergence, double time);

}  // namespace granary::dem
