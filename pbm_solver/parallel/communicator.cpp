#include "pbm_solver/parallel/communicator.hpp"

#include <mpi.h>

#include <algorithm>
#include <vector>

#include "common/launched_by_mpi.hpp"

namespace granary::pbm {
namespace {

constexpr int kDownstream = 1;  // message tag

}  // namespace

Communicator::Communicator() {
  if (!launched_by_mpi()) return;  // starting MPI costs a tenth of a second: too much for small runs
  int provided = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
}

Communicator::~Communicator() {
  int started = 0, finished = 0;
  MPI_Initialized(&started);
  MPI_Finalized(&finished);
  if (started && !finished) MPI_Finalize();
}

double Communicator::sum(double mine) const {
  double all = mine;
  if (size_ > 1) MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return all;
}

void Communicator::max(std::span<double> values) const {
  if (size_ > 1)
    MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
}

void Communicator::shift_down(std::span<const double> send, std::span<double> receive) const {
  if (size_ == 1) return;
  const int above = rank_ > 0 ? rank_ - 1 : MPI_PROC_NULL;
  const int below = rank_ + 1 < size_ ? rank_ + 1 : MPI_PROC_NULL;
  MPI_Sendrecv(send.data(), static_cast<int>(send.size()), MPI_DOUBLE, below, kDownstream, receive.data(),
               static_cast<int>(receive.size()), MPI_DOUBLE, above, kDownstream, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
}

void Communicator::gather(std::span<const double> mine, std::span<double> all) const {
  if (size_ == 1) {
    std::copy(mine.begin(), mine.end(), all.begin());
    return;
  }
  const int count = static_cast<int>(mine.size());
  std::vector<int> counts(static_cast<std::size_t>(size_)), offsets(static_cast<std::size_t>(size_));
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, MPI_COMM_WORLD);
  for (std::size_t r = 1; r < counts.size(); ++r) offsets[r] = offsets[r - 1] + counts[r - 1];
  MPI_Allgatherv(mine.data(), count, MPI_DOUBLE, all.data(), counts.data(), offsets.data(), MPI_DOUBLE, MPI_COMM_WORLD);
}

Status Communicator::agree(Status mine) const {
  double worst[1] = {mine ? 0.0 : static_cast<double>(mine.error().exit)};
  max(worst);
  if (!mine || worst[0] == 0.0) return mine;
  return Error{"another rank could not go on; its message says why.", static_cast<Exit>(static_cast<int>(worst[0]))};
}

}  // namespace granary::pbm
