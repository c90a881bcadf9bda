// Where the horizontal mixer's casing is open, and how wide it is. Its meshes: machine.hpp.
#pragma once

#include "dem_templates/case/dem_case.hpp"

namespace granary::dem {

/// The feed chute on top of the casing, above the feed elements, and the outlet in its floor behind the shaft's end.
struct MixerPorts {
  double chute_from, chute_to;    ///< along x [m]
  double chute_top;               ///< height of its closed lid above the axis (y) [m]
  double chute_half_width;        ///< along z [m]
  double outlet_from, outlet_to;  ///< along x [m]
  double outlet_half_width;       ///< along z [m]
};
MixerPorts mixer_ports(const HorizontalMixer& mixer);

/// Radius of the conical casing at x [m].
double casing_radius(const HorizontalMixer& mixer, double x);
/// The same at the corners of our coarsest mesh, whose flat sides touch the cone [m].
double casing_corner_radius(const HorizontalMixer& mixer, double x);

}  // namespace granary::dem
