// The pairs of particles in LIGGGHTS' neighbour list: which there are, and which touch now.
#pragma once

#include <atom.h>
#include <force.h>
#include <lammps.h>
#include <neigh_list.h>
#include <pair.h>

namespace granary::dem {

/// Calls found(i, j, place) for every pair of the list; i is of this rank, j, at this place among the neighbours of i,
/// may be a ghost. With newton off a pair across a rank boundary is found by both ranks, any other once.
template <class Found>
void for_each_listed_pair(LAMMPS_NS::LAMMPS& lammps, Found&& found) {
  const LAMMPS_NS::NeighList& list = *lammps.force->pair->list;
  for (int n = 0; n < list.inum; ++n) {
    const int i = list.ilist[n], n_neighbours = list.numneigh[i];
    const int* const neighbours = list.firstneigh[i];
    for (int k = 0; k < n_neighbours; ++k) found(i, neighbours[k] & NEIGHMASK, k);
  }
}

/// The same with how near they are: found(i, j, distance^2, (sum of radii)^2).
template <class Found>
void for_each_pair(LAMMPS_NS::LAMMPS& lammps, Found&& found) {
  double** const x = lammps.atom->x;
  const double* const radius = lammps.atom->radius;
  for_each_listed_pair(lammps, [&](int i, int j, int) {
    const double dx = x[i][0] - x[j][0], dy = x[i][1] - x[j][1], dz = x[i][2] - x[j][2];
    const double touching = radius[i] + radius[j];
    found(i, j, dx * dx + dy * dy + dz * dz, touching * touching);
  });
}

}  // namespace granary::dem
