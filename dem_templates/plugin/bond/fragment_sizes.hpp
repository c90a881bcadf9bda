// How large fragments are, and how their sizes are spread. Knows no LIGGGHTS.
#pragma once

#include <map>
#include <vector>

#include "dem_templates/plugin/bond/bond_graph.hpp"
#include "dem_templates/plugin/resize/vector3.hpp"

namespace granary::dem {

struct FragmentParticle {
  Vector3 centre{};     ///< [m]
  double radius = 0.0;  ///< [m]
};

struct FragmentSize {
  double volume = 0.0;           ///< solid [m^3]
  double diameter = 0.0;         ///< of the sphere of that volume [m]
  double spread_diameter = 0.0;  ///< of the ball with the same radius of gyration [m]
};

/// d = (6 V/pi)^(1/3);   d_g = 2 sqrt(5/3) R_g,   R_g^2 = sum m_k (|x_k - c|^2 + 3/5 r_k^2) / sum m_k
/// so that d_g of one sphere is its diameter. Particles of a fragment are followed along its bonds, each by the nearest
/// image; period: of the box along each axis, 0 where it does not repeat [m].
FragmentSize fragment_size(const std::vector<Tag>& fragment, const BondGraph& graph,
                           const std::unordered_map<Tag, FragmentParticle>& particles, const Vector3& period);

/// The smallest of the sizes that, with all below it, make up at least this fraction of the weight.
double weighted_quantile(std::vector<std::pair<double, double>> sizes_and_weights, double fraction);

}  // namespace granary::dem
