// The pairs of particles that touch now, or are about to: one pass over LIGGGHTS' neighbour list.
#pragma once

#include <algorithm>
#include <cmath>

#include <lammps.h>
#include <atom.h>
#include <force.h>
#include <neigh_list.h>
#include <pair.h>

namespace granary::dem {

/// Two particles whose surfaces are nearer than asked. i is of this rank, j may be a ghost.
struct NearPair {
  int i, j;
  double gap;            ///< between the surfaces; negative while they overlap [m]
  double distance;       ///< between the centres [m]
  double approach;       ///< normal relative speed, positive while they come closer [m/s]

  double overlap(const double* radius) const { return -gap / std::min(radius[i], radius[j]); }
};

/// Calls found(NearPair) for each pair nearer than `reach` [m]. With newton off a pair across a rank boundary is found
/// by both ranks, any other once.
template <class Found>
void for_each_near_pair(LAMMPS_NS::LAMMPS& lammps, double reach, Found&& found) {
  const LAMMPS_NS::NeighList& list = *lammps.force->pair->list;
  double** const x = lammps.atom->x;
  double** const v = lammps.atom->v;
  const double* const radius = lammps.atom->radius;

  for (int n = 0; n < list.inum; ++n) {
    const int i = list.ilist[n];
    const double* const xi = x[i];
    const double ri = radius[i] + reach;
    const int* const neighbours = list.firstneigh[i];
    const int n_neighbours = list.numneigh[i];
    for (int k = 0; k < n_neighbours; ++k) {
      const int j = neighbours[k] & NEIGHMASK;
      const double dx = xi[0] - x[j][0], dy = xi[1] - x[j][1], dz = xi[2] - x[j][2];
      const double distance2 = dx * dx + dy * dy + dz * dz;
      const double near = ri + radius[j];
      if (distance2 >= near * near) continue;

      const double distance = std::sqrt(distance2);
      const double closing = dx * (v[j][0] - v[i][0]) + dy * (v[j][1] - v[i][1]) + dz * (v[j][2] - v[i][2]);
      found(NearPair{i, j, distance - radius[i] - radius[j], distance, distance > 0.0 ? closing / distance : 0.0});
    }
  }
}

}  // namespace granary::dem
