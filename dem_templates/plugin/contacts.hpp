// The pairs of particles in LIGGGHTS' neighbour list: which there are, and which touch now.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <atom.h>
#include <force.h>
#include <lammps.h>
#include <neigh_list.h>
#include <pair.h>

namespace granary::dem {

/// Calls found(i, j) for every pair of the list; i is of this rank, j may be a ghost. With newton off a pair across a
/// rank boundary is found by both ranks, any other once.
template <class Found>
void for_each_listed_pair(LAMMPS_NS::LAMMPS& lammps, Found&& found) {
  const LAMMPS_NS::NeighList& list = *lammps.force->pair->list;
  for (int n = 0; n < list.inum; ++n) {
    const int i = list.ilist[n], n_neighbours = list.numneigh[i];
    const int* const neighbours = list.firstneigh[i];
    for (int k = 0; k < n_neighbours; ++k) found(i, neighbours[k] & NEIGHMASK);
  }
}

/// The same with their places: found(i, j, slot, distance^2, (sum of radii)^2).
template <class Found>
void for_each_pair(LAMMPS_NS::LAMMPS& lammps, Found&& found) {
  const LAMMPS_NS::NeighList& list = *lammps.force->pair->list;
  double** const x = lammps.atom->x;
  const double* const radius = lammps.atom->radius;

  std::size_t slot = 0;
  for (int n = 0; n < list.inum; ++n) {
    const int i = list.ilist[n];
    const double xi = x[i][0], yi = x[i][1], zi = x[i][2], ri = radius[i];
    const int* const neighbours = list.firstneigh[i];
    const int n_neighbours = list.numneigh[i];
    for (int k = 0; k < n_neighbours; ++k, ++slot) {
      const int j = neighbours[k] & NEIGHMASK;
      const double dx = xi - x[j][0], dy = yi - x[j][1], dz = zi - x[j][2], touching = ri + radius[j];
      found(i, j, slot, dx * dx + dy * dy + dz * dz, touching * touching);
    }
  }
}

}  // namespace granary::dem
