// Classes that are faster than the step and hold next to nothing: which they are, and how far they are slowed down.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pbm_solver/time/compartment_row.hpp"
#include "pbm_solver/time/state_passes.hpp"

namespace granary::pbm {

/// A class that an Euler step of half the step would empty limits the step, unless it is among the smallest, which
/// together hold at most a tenth of the tolerance of their compartment's solids: of these, the ones that lose what they
/// hold within the step take part in aggregation and breakage by a factor < 1 during it (births and deaths alike, so
/// the balance stays closed), that is, what they should hand on is delayed by up to a step. Rates taken implicitly do
/// not count.
class SmallClasses {
 public:
  SmallClasses(const CompartmentRow& row, double tolerance);

  /// A new step from `state`, which holds `held` in each compartment.
  void begin_step(std::span<const double> state, std::span<const Held> held);
  /// The loss rates by what is taken explicitly [1/s]: those of the row less `implicit_rate` (empty: none).
  void set_losses(std::span<const double> implicit_rate);

  /// The longest step, at most h, that empties no class but those slowed down. rates: at the state.
  double limit_by_emptying(std::span<const double> rates, double h);
  /// The longest step, at most h, in which what is born into classes slowed down leaves them small: otherwise they
  /// would fill up over long steps and have to be emptied in very short ones.
  double limit_by_filling(std::span<const double> rates, double h);
  /// Slows down for a step of h; false if no class of this rank is.
  bool slow_down(double h);
  /// Factor of each class [block][class][lane]; empty: 1.
  std::span<const double> participation() const { return participation_; }

  /// What became of the negative values of a stage.
  struct Negative {
    bool slowed = false;   ///< small classes: slowed down further, the step is to be repeated
    bool shorten = false;  ///< large classes
    Held amount{};         ///< what is tolerated: born negative, or decaying implicitly
  };
  /// Adds what a stage of a step of h holds below 0 to each compartment's account. tolerant: what is not fast may be
  /// below 0.
  void check(std::span<const double> stage, double h, bool tolerant, std::span<Negative> accounts);

 private:
  /// Whether a loss rate matters in a step of h.
  static bool is_fast(double h, double loss_rate);

  enum class Size : char { large, small, dust };
  void mark_sizes();
  void check_block(std::size_t b, std::span<const double> stage, double h, bool tolerant, std::span<Negative> accounts);
  bool emptied(std::span<const double> rates, std::size_t x, std::size_t k, double h) const;
  /// Calls each(place of the class, compartment, class).
  template <class Do>
  void for_each_fast(double h, Do&& each) const;

  const CompartmentRow* row_;
  double tolerance_;
  std::span<const double> state_;
  std::span<const Held> held_;
  bool marked_ = false;         ///< sizes_ are those of state_
  std::vector<Size> sizes_;     ///< [block][class][lane]
  LaneVector all_loss_, loss_;  ///< loss rates, and those by what is taken explicitly; [block][class][lane]
  double caution_ = 1.0;        ///< of explicit steps: on the loss rates of classes slowed down
  double fastest_ = 0.0;        ///< the largest of them
  LaneVector participation_;
};

}  // namespace granary::pbm
