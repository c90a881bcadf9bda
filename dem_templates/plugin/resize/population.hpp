// population.json: how many particles of which sizes each compartment should hold. Format: docs/exchange_formats.md.
#pragma once

#include <filesystem>
#include <vector>

#include "common/result.hpp"

namespace granary::dem {

struct CompartmentPopulation {
  double from = 0.0, to = 0.0;    ///< along the axis [m]
  std::vector<double> diameters;  ///< of each particle, ascending [m]

  double volume() const;  ///< [m^3]
};

struct ResizePopulation {
  double density = 0.0;                             ///< [kg/m^3]
  std::vector<CompartmentPopulation> compartments;  ///< in order along the axis

  double largest_diameter() const;  ///< [m]; 0 if there are no particles
  double volume() const;            ///< of all compartments [m^3]
};

Result<ResizePopulation> read_population(const std::filesystem::path& file);

}  // namespace granary::dem
