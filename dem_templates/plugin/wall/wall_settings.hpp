// What `fix ID GROUP granary/wall ...` asks for. Syntax: docs/dem_styles.md. Knows no LIGGGHTS.
#pragma once

#include <vector>

#include "dem_templates/plugin/input/fix_arguments.hpp"
#include "dem_templates/plugin/wall/contact_law.hpp"
#include "dem_templates/plugin/wall/wall_body.hpp"
#include "dem_templates/plugin/wall/wear.hpp"

namespace granary::dem {

struct WallSettings {
  int type = 1;  ///< LIGGGHTS' atom type of the walls
  RollingModel rolling = RollingModel::none;
  bool cohesion = false;
  bool pushes = true;            ///< false: it only watches
  std::vector<WallBody> bodies;  ///< meshes, planes, cylinders
  WearSettings wear;
};

/// The keywords that read_wall_settings() understands.
std::vector<FixArguments::Keyword> wall_keywords();

/// Reads the mesh files too. What is wrong is among the problems of `arguments` afterwards.
WallSettings read_wall_settings(FixArguments& arguments);

}  // namespace granary::dem
