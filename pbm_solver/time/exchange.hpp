// What the ranks that share a row of compartments tell each other. The solver knows this interface; MPI is behind it in
// parallel/.
#pragma once

#include <algorithm>
#include <span>

namespace granary::pbm {

/// Which compartments a rank computes.
struct Share {
  int first = 0;
  int count = 1;
};

/// Neighbouring compartments lie on the same or on neighbouring ranks, in order. Every rank calls the same functions in
/// the same order with the same sizes per compartment.
class Exchange {
 public:
  virtual ~Exchange() = default;
  virtual Share share() const = 0;
  /// Sends the state of my last compartment to the rank below and receives that of the last one above me into
  /// `upstream` (left alone on the first rank).
  virtual void pass_downstream(std::span<const double> last, std::span<double> upstream) = 0;
  /// What every rank has for its compartments, in the order of the compartments, on every rank.
  virtual void gather(std::span<const double> mine, std::span<double> all) = 0;
};

/// One rank that computes every compartment.
class Alone : public Exchange {
 public:
  explicit Alone(int n_compartments) : n_(n_compartments) {}
  Share share() const override { return {0, n_}; }
  void pass_downstream(std::span<const double>, std::span<double>) override {}
  void gather(std::span<const double> mine, std::span<double> all) override {
    std::copy(mine.begin(), mine.end(), all.begin());
  }

 private:
  int n_;
};

}  // namespace granary::pbm
