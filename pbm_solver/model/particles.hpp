// The mean particle of every class in every lane of a block: what kernels and selection functions look at.
#pragma once

#include <span>
#include <vector>

#include "pbm_solver/model/class_grid.hpp"
#include "pbm_solver/model/simd/lanes.hpp"

namespace granary::pbm {

/// Where a diameter lies between the DEM's class centres, linear in ln d; beyond the ends: the end class.
struct ClassPosition {
  int lower = 0;
  double to_upper = 0.0;  ///< 0: at class `lower`, 1: at the next
};

/// Position of a diameter among rising centres: ln_centre = ln of the class centres.
ClassPosition position_of(std::span<const double> ln_centre, double ln_diameter);

/// Volume of the liquid outside the pores of a particle: l - min(phi g, l), and the film it makes on a sphere of volume
/// V:
///   h = 1/2 (6/pi)^{1/3} [V^{1/3} - (V - l_ext)^{1/3}]      (docs/pbm_equations.md#particles)
double external_liquid(double liquid, double gas, double saturation_factor);
double film_thickness(double volume, double external_liquid);

/// The solids of each class, once for every lane. Shape [class][lanes] each.
struct SolidLanes {
  SolidLanes(const ClassGrid& grid, const Materials& materials, int lanes);
  LaneVector solid;     ///< [m^3]
  LaneVector mass;      ///< of the solids [kg]
  LaneVector dry_area;  ///< pi d^2 of a pore-free sphere of the solids [m^2]
};

/// Structure of arrays, shape [class][lanes] each. The mean particle of a class is its pivot's solids with
/// liquid/number and gas/number; a class without particles is dry and without pores.
class ParticleTable {
 public:
  ParticleTable(const SolidLanes& solids, const Materials& materials);

  /// Liquid and gas of the mean particles [m^3] from the totals of the classes.
  void look_at(const double* number, const double* liquid, const double* gas);
  /// Whether, in a class that holds more than 1e-8 of its compartment's solids, the volume or the film has moved by
  /// more than `tolerance` since remember(): |dV| <= tolerance V and |dl_ext| <= tolerance (l_ext + asperity pi d^2).
  bool moved(const double* number, const double* liquid, const double* gas, double tolerance, double asperity,
             int lanes) const;
  /// 1 for the classes with at least this liquid fraction, else 0; [class][lanes].
  LaneVector wet(double least_liquid_fraction) const;
  /// Works out the figures below and remembers the liquid and gas they belong to.
  void remember();

  /// One lane of the table below.
  ParticleTable lane(std::size_t lane, std::size_t lanes) const;

  LaneVector diameter;          ///< [m]
  LaneVector inverse_diameter;  ///< [1/m]
  LaneVector inverse_mass;      ///< [1/kg]
  LaneVector film;              ///< thickness of the external liquid [m]
  LaneVector liquid_fraction;   ///< external liquid over volume [-]
  LaneVector porosity;          ///< (l + g) / V [-]
  LaneVector volume;            ///< [m^3]

 private:
  const SolidLanes* solids_;
  double saturation_factor_, liquid_density_;
  bool known_ = false;
  LaneVector liquid_, gas_, known_liquid_;  ///< now; and external liquid at remember() [m^3]
};

}  // namespace granary::pbm
