// The bodies particles can hit: those of granary/wall, and meshes and primitive walls of LIGGGHTS' wall/gran fixes.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace granary::dem {

/// A particle of this rank touches a body.
struct WallTouch {
  int particle = 0;                  ///< local index
  double overlap = 0.0;              ///< over the particle's radius
  std::array<double, 3> normal{};    ///< unit vector from the wall to the particle's centre
  std::array<double, 3> velocity{};  ///< of the wall at the touch [m/s]
};

class Wall {
 public:
  virtual ~Wall() = default;
  /// Calls `found` once for each particle that touches this body now: where it touches several triangles, with the
  /// deepest touch. Valid after the fix of this body has computed the forces of the step.
  virtual void touches(const std::function<void(const WallTouch&)>& found) const = 0;
  /// Place of that fix in LIGGGHTS' list of fixes.
  int fix_index = 0;
};

/// The mesh of `fix ID all mesh/surface...`. Error: no such mesh, or no wall/gran fix with history uses it.
Result<std::unique_ptr<Wall>> find_mesh_wall(LAMMPS_NS::LAMMPS& lammps, const std::string& mesh_fix);
/// The primitive wall of `fix ID all wall/gran ... primitive ...`.
Result<std::unique_ptr<Wall>> find_primitive_wall(LAMMPS_NS::LAMMPS& lammps, const std::string& wall_fix);
/// All of them.
std::vector<std::unique_ptr<Wall>> find_all_walls(LAMMPS_NS::LAMMPS& lammps);

}  // namespace granary::dem
