// What particles take off the triangles of a body: by sliding on them (Archard) and by hitting them (Finnie).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "dem_templates/plugin/resize/triangles.hpp"

namespace granary::dem {

struct WearSettings {
  double archard = 0.0;  ///< k / H: wear coefficient over hardness [1/Pa]; 0: no wear by sliding
  double finnie = 0.0;   ///< 1 / (p psi K), K = 2: of the flow stress p [1/Pa]; 0: no wear by impacts
  std::string file;      ///< beginning of the files' names
  long every = 0;        ///< steps between two files; 0: at the end of a run only

  bool on() const { return archard > 0.0 || finnie > 0.0; }
};

/// Volume that sliding takes off [m^3]:   V = k F_n s / H
/// normal_force: [N], a pull wears nothing; slip: way of the particle's surface over the wall's [m].
/// Source: J. F. Archard, Contact and rubbing of flat surfaces, J. Appl. Phys. 24 (1953).
inline double archard_volume(double k_over_h, double normal_force, double slip) {
  return normal_force > 0.0 ? k_over_h * normal_force * slip : 0.0;
}

/// Volume that one impact of a particle takes off [m^3]:
///   V = m v^2 / (p psi K) f,   f = sin 2a - 6/K sin^2 a   for tan a <= K/6,   K/6 cos^2 a   above;   K = 2
/// speed: of the particle against the wall [m/s]; normal_speed: its part into the wall: sin a = normal_speed / speed.
/// Source: I. Finnie, Erosion of surfaces by solid particles, Wear 3 (1960).
double finnie_volume(double factor, double mass, double speed, double normal_speed);

/// Of one body; its triangles in the order of the file. [m^3]
struct Wear {
  std::vector<double> by_sliding, by_impacts;

  explicit Wear(std::size_t n_triangles = 0) : by_sliding(n_triangles), by_impacts(n_triangles) {}
};

/// A legacy VTK file: the triangles with the volumes taken off [m^3] and the depths these make [m] as cell data.
std::string wear_vtk(const std::vector<Triangle>& triangles, const Wear& wear, const std::string& title);

}  // namespace granary::dem
