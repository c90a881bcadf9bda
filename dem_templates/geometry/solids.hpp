// Closed bodies that the machines are made of: bodies and hollow shells of revolution, blades.
#pragma once

#include <functional>
#include <vector>

#include "dem_templates/geometry/mesh.hpp"

namespace granary::dem {

inline constexpr double kWallThickness = 0.010;   ///< of a vessel [m]: its outside is on no neighbour list
inline constexpr double kBladeThickness = 0.002;  ///< [m]

enum class Axis { x, y, z };
Vec3 unit(Axis axis);

/// A point of the half plane that is turned around the axis: position along it, distance from it. [m]
struct ProfilePoint {
  double along = 0.0, radius = 0.0;
};

/// Body of revolution with n_around flat sides. The profile runs with growing `along` from radius 0 to radius 0; radii
/// between are those of the vertices. Its angle is measured from y (axis x), z (axis y) or x (axis z) on.
Mesh body_of_revolution(Axis axis, const std::vector<ProfilePoint>& profile, int n_around);

/// Circle and regular n-gon: the n-gon's corner radius whose flats touch the circle.
double touching_radius(double radius, int n_around);

/// A closed vessel with walls of some thickness: two surfaces of revolution, the inner one inside the outer one, with
/// the same number of profile points and sides. Cells are counted along the profile and around.
struct Vessel {
  using Cells = std::function<bool(int along, int around)>;

  Axis axis = Axis::x;
  std::vector<ProfilePoint> inner, outer;
  int n_around = 24;
  Cells open;    ///< cells left out of both surfaces: the hole, with a rim through the wall
  Cells raised;  ///< cells lifted off both surfaces, with side walls: a dome or chute
  std::function<Vec3(Vec3)> lift_inner, lift_outer;  ///< where the corners of raised cells go
};
Mesh vessel(const Vessel& form);

/// A flat blade on a rotor. Its tip corners lie exactly on the tip circle; its two long edges are cut across the axis,
/// so that no bevel drives particles under it.
struct Blade {
  Axis axis = Axis::x;                         ///< of the rotor, through `centre`
  Vec3 centre;                                 ///< of the blade, on the axis [m]
  double angle = 0.0;                          ///< around the axis [rad]
  double root_radius = 0.0, tip_radius = 0.0;  ///< [m]
  double width = 0.0, thickness = 0.0;         ///< [m]
  double pitch = 0.0;  ///< 0: the face looks where the blade goes; towards pi/2: along the axis [rad]
};
Mesh blade(const Blade& form);

/// How far the blade reaches from its centre along the axis, to either side [m].
double half_extent(const Blade& form);

/// Volume of the blade outside a shaft of that radius, the shaft's curvature left out. [m^3]
double blade_volume(const Blade& form, double shaft_radius);

}  // namespace granary::dem
