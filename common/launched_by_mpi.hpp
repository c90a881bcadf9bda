// Whether an MPI launcher started this process. Knows no MPI.
#pragma once

#include <cstdlib>

namespace granary {

/// A launcher leaves its mark in the environment of each rank; a program started by itself has none.
inline bool launched_by_mpi() {
  for (const char* mark : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "PMI_SIZE"})
    if (std::getenv(mark) != nullptr) return true;
  return false;
}

}  // namespace granary
