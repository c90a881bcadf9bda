// The ranks of one run: who I am, what all have in common, one message down the row. The only door to MPI.
// Without a launcher (mpirun, srun) a process is one rank and MPI is never started.
#pragma once

#include <span>

#include "common/result.hpp"

namespace granary::pbm {

class Communicator {
 public:
  /// Starts MPI if this process was started by an MPI launcher.
  Communicator();
  ~Communicator();
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;

  int rank() const { return rank_; }
  int size() const { return size_; }
  bool first() const { return rank_ == 0; }

  double sum(double mine) const;
  /// Element by element, over all ranks.
  void max(std::span<double> values) const;
  /// Sends to the rank below (rank + 1), receives from the one above (rank - 1); at the ends of the row nothing.
  void shift_down(std::span<const double> send, std::span<double> receive) const;
  /// Concatenates what each rank has, in order of rank, on every rank.
  void gather(std::span<const double> mine, std::span<double> all) const;
  /// One rank's error is everyone's: fails on every rank if it failed on any, so that nobody waits for the others for
  /// ever.
  Status agree(Status mine) const;

 private:
  int rank_ = 0;
  int size_ = 1;
};

}  // namespace granary::pbm
