// Agglomerates as lists of spheres: packed, read, written, turned and placed. Plain geometry: no LIGGGHTS.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/result.hpp"
#include "dem_templates/plugin/resize/free_space.hpp"
#include "dem_templates/plugin/resize/vector3.hpp"

namespace granary::dem {

struct AgglomerateSphere {
  Vector3 centre{};     ///< [m]
  double radius = 0.0;  ///< [m]
};
using Agglomerate = std::vector<AgglomerateSphere>;

/// Diameter of the ball about the mean of the centres that holds all spheres [m].
double agglomerate_diameter(const Agglomerate& agglomerate);
/// Solid volume over that ball's [-].
double solid_fraction(const Agglomerate& agglomerate);

/// n equal spheres at random in a ball, none overlapping. Of the random starts the first that fits is taken; if none
/// does, the ball is made larger by 0.5 % and so on: ask agglomerate_diameter() what came out. The same bits for the
/// same seed. Meant for up to some hundred spheres. Cost: O(n^2) a sweep.
Agglomerate pack_ball(int n, double sphere_diameter, double ball_diameter, std::uint64_t seed);

/// A file `{"format": "granary-agglomerates-1", "agglomerates": [{"spheres_m": [[x, y, z, radius], ...]}, ...]}`.
/// Error: not such a file, an agglomerate without spheres, a radius that is not positive.
Result<std::vector<Agglomerate>> read_agglomerates(const std::filesystem::path& file);
Status write_agglomerates(const std::filesystem::path& file, const std::vector<Agglomerate>& agglomerates);

struct Placing {
  int count = 0;           ///< how many
  std::uint64_t seed = 1;  ///< the same seed gives the same places
  int tries = 5000;        ///< random places for one agglomerate
};

/// Copies of the shapes, taken in turns, at random places and orientations: every sphere wholly in the space, clear of
/// its walls, of the spheres that are there and of each other. Error: no room was found; says for how many there was.
Result<std::vector<Agglomerate>> place_agglomerates(const std::vector<Agglomerate>& shapes, const FreeSpace& space,
                                                    const Agglomerate& there, const Placing& placing);

}  // namespace granary::dem
