// How granary-dem ends: with one exit code from all ranks, and a message on stderr.
#pragma once

#include <mpi.h>

#include <string>

#include "common/result.hpp"

namespace granary::dem {

constexpr int kDivergedExit = 20;  ///< docs/exchange_formats.md

/// All ranks call it. Rank 0 says the message; MPI is closed; the program ends with this code on every rank, so that
/// mpirun ends with it too.
[[noreturn]] void end_program(MPI_Comm world, int exit_code, const std::string& message);

/// All ranks call it with their own status: if any failed, the first one's message ends the program everywhere.
void end_if_failed(MPI_Comm world, const Status& status);

}  // namespace granary::dem
