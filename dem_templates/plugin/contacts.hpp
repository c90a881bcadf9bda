// The pairs of particles in LIGGGHTS' neighbour list: which there are, which touch now, and which have touched.
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

/// The first number in [from, to) that is not zero; `to` if all are.
inline const int* first_flag(const int* from, const int* to) {
  constexpr int kAtOnce = 8;  // most are zero
  for (; to - from >= kAtOnce; from += kAtOnce) {
    int any = 0;
    for (int k = 0; k < kAtOnce; ++k) any |= from[k];
    if (any != 0) break;
  }
  while (from < to && *from == 0) ++from;
  return from;
}

/// Calls found(i, j, slot) for every pair of the list that has touched at some step since the list was made: the pair
/// style flags it in the history that it keeps (not null: PairGran has one). slot: the same for a pair as long as the
/// list lives, ascending.
template <class Found>
void for_each_pair_that_touched(LAMMPS_NS::LAMMPS& lammps, Found&& found) {
  const LAMMPS_NS::NeighList& list = *lammps.force->pair->list;
  const int* const* const flags = lammps.force->pair->listgranhistory->firstneigh;
  const int* const ilist = list.ilist;
  // Particles have few neighbours, and the flags of the next one follow at once, but at the end of a page: so the flags
  // of a page are looked through in one go.
  for (int n = 0, next = 0; n < list.inum; n = next) {
    const int *flag = flags[ilist[n]], *end = flag;
    for (next = n; next < list.inum && flags[ilist[next]] == end; ++next) end += list.numneigh[ilist[next]];
    for (flag = first_flag(flag, end); flag < end; flag = first_flag(flag + 1, end)) {
      while (flag - flags[ilist[n]] >= list.numneigh[ilist[n]]) ++n;
      const int i = ilist[n];
      const auto k = flag - flags[i];
      found(i, list.firstneigh[i][k] & NEIGHMASK, static_cast<std::uint64_t>(n) << 32 | static_cast<std::uint64_t>(k));
    }
  }
}

}  // namespace granary::dem
