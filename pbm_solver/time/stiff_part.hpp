// The part of the rates that may be far faster than everything else, as a linear map that is frozen during a step.
#pragma once

#include <span>
#include <vector>

#include "pbm_solver/time/compartment_row.hpp"
#include "pbm_solver/time/state_passes.hpp"

namespace granary::pbm {

/// B y = A y - R y: breakage A at frozen selection rates, and what leaves the grid from its top classes, where every
/// collision leads above the last pivot: R = their frozen loss rates, into the ledger's oversize. Both keep every
/// balance, and 1 - gamma B is triangular: it is inverted by substitution, to round-off.
class StiffPart {
 public:
  StiffPart(const CompartmentRow& row, int threads);

  /// False: the case has nothing of the kind.
  bool exists() const { return exists_; }
  /// Takes the rates at the last CompartmentRow::rates() (with breakage and without participation).
  void freeze();
  /// Whether a step of h is to take B implicitly: whether in any compartment of this rank classes that break faster
  /// than an explicit method could follow hold anything at all, or so much passes during h through those that leave as
  /// fast, that it cannot be neglected (they are slowed down otherwise, see small_classes.hpp). Right after freeze().
  /// held: what each compartment holds.
  bool needed(std::span<const double> state, std::span<const double> rates, double h, std::span<const Held> held,
              double tolerance) const;
  /// Rate at which a class loses by B [1/s], [block][class][lane].
  std::span<const double> rate() const { return rate_; }
  /// From now on classes take part by these factors [block][class][lane]; empty: 1.
  void slow_down(std::span<const double> participation);
  /// out += factor B y; breakage = false: -R y alone.
  void add(double factor, std::span<const double> y, std::span<double> out, bool breakage = true) const;
  /// Solves y - gamma B y = r in place.
  void solve(double gamma, std::span<double> y) const;

 private:
  void leave(std::size_t b, double factor, const double* y, double* out, double* ledger) const;

  const CompartmentRow* row_;
  const simd::Operations* do_;
  int threads_;
  bool exists_;
  std::vector<std::size_t> top_;  ///< classes whose every pair lies above the grid
  // [block][class][lane]:
  LaneVector rate_, leaving_rate_;       ///< of A and R together, of R
  LaneVector selection_, leaving_;       ///< S and R times the participation
  mutable LaneVector damped_, scratch_;  ///< S / D (see solve()); [block][2][class][lane]
};

}  // namespace granary::pbm
