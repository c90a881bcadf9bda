// The compartments of a row shared by the ranks in blocks, and what they tell each other through the communicator.
#pragma once

#include "pbm_solver/parallel/communicator.hpp"
#include "pbm_solver/time/exchange.hpp"

namespace granary::pbm {

/// Block of rank r of n: the first (count mod n) ranks have one compartment more.
inline Share block_of(int n_compartments, int rank, int n_ranks) {
  const int each = n_compartments / n_ranks, more = n_compartments % n_ranks;
  return {rank * each + (rank < more ? rank : more), each + (rank < more ? 1 : 0)};
}

class RankExchange : public Exchange {
 public:
  /// At most as many ranks as compartments. The communicator must outlive it.
  RankExchange(const Communicator& ranks, int n_compartments)
      : ranks_(&ranks), share_(block_of(n_compartments, ranks.rank(), ranks.size())) {}
  Share share() const override { return share_; }
  void pass_downstream(std::span<const double> last, std::span<double> upstream) override {
    ranks_->shift_down(last, upstream);
  }
  void gather(std::span<const double> mine, std::span<double> all) override { ranks_->gather(mine, all); }

 private:
  const Communicator* ranks_;
  Share share_;
};

}  // namespace granary::pbm
