#include "dem_templates/plugin/ending.hpp"

#include <cstdio>
#include <cstdlib>

namespace granary::dem {

void end_program(MPI_Comm world, int exit_code, const std::string& message) {
  int rank = 0;
  MPI_Comm_rank(world, &rank);
  if (rank == 0) std::fprintf(stderr, "granary-dem: %s\n", message.c_str());
  std::fflush(nullptr);
  MPI_Finalize();
  std::_Exit(exit_code);  // LIGGGHTS is in the middle of a command: nothing of it can be taken down
}

void end_if_failed(MPI_Comm world, const Status& status) {
  int rank = 0, n_ranks = 1;
  MPI_Comm_rank(world, &rank);
  MPI_Comm_size(world, &n_ranks);

  int mine = status ? n_ranks : rank, first = n_ranks;
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, world);
  if (first == n_ranks) return;

  int code = status ? 0 : static_cast<int>(status.error().exit);
  MPI_Bcast(&code, 1, MPI_INT, first, world);
  std::string message = status ? "" : status.error().message;
  int length = static_cast<int>(message.size());
  MPI_Bcast(&length, 1, MPI_INT, first, world);
  message.resize(static_cast<std::size_t>(length));
  MPI_Bcast(message.data(), length, MPI_CHAR, first, world);
  end_program(world, code, message);
}

}  // namespace granary::dem
