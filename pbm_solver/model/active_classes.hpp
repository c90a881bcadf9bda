// The classes of one compartment that hold particles, with their mean particle: what kernels and selection functions
// look at.
#pragma once

#include <span>
#include <vector>

#include "pbm_solver/model/class_grid.hpp"

namespace granary::pbm {

/// The state of one compartment, shape (n_classes) each.
struct Fields {
  std::span<const double> number;  ///< particles [-]
  std::span<const double> liquid;  ///< total liquid of the class [m^3]
  std::span<const double> gas;     ///< total gas of the class [m^3]
};

/// Where a diameter lies between the DEM's class centres, linear in ln d; beyond the ends: the end class.
struct ClassPosition {
  int lower = 0;
  double to_upper = 0.0;  ///< 0: at class `lower`, 1: at the next
};

/// Position of a diameter among rising centres: ln_centre = ln of the class centres.
ClassPosition position_of(std::span<const double> ln_centre, double diameter);

/// Volume of the liquid outside the pores of a particle: l - min(phi g, l), and the film it makes on a sphere of volume
/// V:
///   h = 1/2 (6/pi)^{1/3} [V^{1/3} - (V - l_ext)^{1/3}]      (docs/pbm_equations.md#particles)
double external_liquid(double liquid, double gas, double saturation_factor);
double film_thickness(double volume, double external_liquid);

/// Structure of arrays over the classes that hold particles (more than 1e-40 of the solids), in rising class index;
/// shape (size) unless said. The mean particle of a class is its pivot's solids with liquid/number and gas/number.
struct ActiveClasses {
  std::vector<int> index, i, j;                 ///< class; its row and column
  std::vector<std::size_t> row_begin;           ///< first active class of each row, shape (rows + 1)
  std::vector<double> number, liquid, gas;      ///< as they take part: the class totals times the participation
  std::vector<double> solid_1, solid_2, solid;  ///< of one particle [m^3]
  std::vector<double> volume, diameter, inverse_diameter;  ///< of one particle with liquid and gas [m^3], [m], [1/m]
  std::vector<double> inverse_mass;                        ///< [1/kg]
  std::vector<double> film;                                ///< thickness of the external liquid [m]
  std::vector<double> liquid_fraction;                     ///< external liquid over volume [-]
  std::vector<double> porosity;                            ///< (l + g) / V [-]
  std::vector<ClassPosition> dem;                          ///< among the DEM's size classes, if there are any

  std::size_t size() const { return index.size(); }

  /// @param participation  factor 0..1 on what each class takes part with; empty: 1 everywhere   shape (n_classes)
  /// @param ln_dem_diameter  ln of the DEM's class centres; empty: no DEM
  void assign(const ClassGrid& grid, const Materials& materials, Fields state, std::span<const double> participation,
              std::span<const double> ln_dem_diameter);

 private:
  void clear();
  void append(const ClassGrid& grid, const Materials& materials, std::size_t k, double number, double liquid,
              double gas, double participation);
};

}  // namespace granary::pbm
