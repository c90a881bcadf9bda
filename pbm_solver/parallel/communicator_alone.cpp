// Built with -DGRANARY_WITH_MPI=OFF: one rank.
#include <algorithm>

#include "pbm_solver/parallel/communicator.hpp"

namespace granary::pbm {

Communicator::Communicator() = default;
Communicator::~Communicator() = default;
double Communicator::sum(double mine) const { return mine; }
void Communicator::max(std::span<double>) const {}
void Communicator::shift_down(std::span<const double>, std::span<double>) const {}
void Communicator::gather(std::span<const double> mine, std::span<double> all) const {
  std::copy(mine.begin(), mine.end(), all.begin());
}
Status Communicator::agree(Status mine) const { return mine; }

}  // namespace granary::pbm
