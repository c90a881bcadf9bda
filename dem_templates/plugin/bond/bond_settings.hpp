// What `fix ID GROUP granary/bond ...` asks for. Syntax: docs/dem_styles.md. Knows no LIGGGHTS.
#pragma once

#include <string>
#include <vector>

#include "dem_templates/plugin/bond/bond_law.hpp"
#include "dem_templates/plugin/bond/strength.hpp"
#include "dem_templates/plugin/input/fix_arguments.hpp"

namespace granary::dem {

struct BondSettings {
  BondMaterial material;
  double radius_scale = 1.0;  ///< bond radius over the smaller of the two radii
  double radius = 0.0;        ///< bond radius instead [m]; 0: by the scale
  double gap = 0.0;           ///< between surfaces, up to which a pair is bonded [m]
  double create = 0.0;        ///< DEM time from which bonds are made [s]
  bool whole_group = false;   ///< all of the group are one agglomerate
  StrengthScatter scatter = StrengthScatter::none;
  double spread = 0.0;
  std::uint64_t seed = 1;
  std::string fragments, breaks;  ///< files; "": not written
  long every = 0;                 ///< steps between samples
  long look = 10;                 ///< steps between looks at who leans on whom
  double cause_window = 1e-3;     ///< [s]

  double bond_radius(double radius_a, double radius_b) const {
    return radius > 0.0 ? radius : radius_scale * std::min(radius_a, radius_b);
  }
};

/// The keywords that read_bond_settings() understands.
std::vector<FixArguments::Keyword> bond_keywords();

/// What is wrong is among the problems of `arguments` afterwards.
BondSettings read_bond_settings(FixArguments& arguments);

}  // namespace granary::dem
