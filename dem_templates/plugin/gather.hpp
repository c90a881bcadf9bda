// Numbers of all ranks, one after the other, on every rank.
#pragma once

#include <mpi.h>

#include <vector>

namespace granary::dem {

/// All ranks call it.
inline std::vector<double> gather_all(MPI_Comm world, const std::vector<double>& mine) {
  int n_ranks = 1;
  MPI_Comm_size(world, &n_ranks);
  if (n_ranks == 1) return mine;
  const int n_mine = static_cast<int>(mine.size());
  std::vector<int> sizes(static_cast<std::size_t>(n_ranks)), starts(static_cast<std::size_t>(n_ranks), 0);
  MPI_Allgather(&n_mine, 1, MPI_INT, sizes.data(), 1, MPI_INT, world);
  for (std::size_t r = 1; r < sizes.size(); ++r) starts[r] = starts[r - 1] + sizes[r - 1];
  std::vector<double> all(static_cast<std::size_t>(starts.back() + sizes.back()));
  MPI_Allgatherv(mine.data(), n_mine, MPI_DOUBLE, all.data(), sizes.data(), starts.data(), MPI_DOUBLE, world);
  return all;
}

}  // namespace granary::dem
