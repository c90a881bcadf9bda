// One error-controlled step of the row of compartments: explicit, conservative, never negative.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/result.hpp"
#include "pbm_solver/time/compartment_row.hpp"
#include "pbm_solver/time/exchange.hpp"
#include "pbm_solver/time/step_control.hpp"

namespace granary::pbm {

/// What granary-pbm ends with when a run cannot keep its tolerance (docs/exchange_formats.md).
inline constexpr Exit kToleranceNotKept = static_cast<Exit>(20);

struct WorkCount {
  std::int64_t steps = 0;
  std::int64_t rejected = 0;
  std::int64_t rhs_evaluations = 0;
};

/// The strong-stability-preserving Runge-Kutta method with 4 stages and order 3, its error from an embedded method of
/// order 2:
///
///   u1 = u + h/2 f(u),  u2 = u1 + h/2 f(u1),  u3 = 2/3 u + 1/3 (u2 + h/2 f(u2)),  u+ = u3 + h/2 f(u3)
///   error = h (-f0 - f1 - f2 + 3 f3) / 12
///
/// Every stage is a mean of Euler steps of h/2, so a state stays positive as long as those do; that is checked, nothing
/// is ever clipped. A class that would be emptied in h/2 shortens the step, unless it is among the smallest, which
/// together hold a tenth of the tolerance of their compartment's solids: such a class takes part in aggregation and
/// breakage by a factor < 1 during this step (births and deaths alike, so the balance stays closed), that is, what it
/// should hand on is delayed by up to a step.
///
/// Error norm: the largest, over compartments and over {number, solid volume, liquid, gas}, of the sum of absolute
/// errors over the sum held there, relative to the tolerance. To what is held come 1e-3 of the row's mean and of what
/// feed and spray bring between two outputs (a start from empty, a spray onto the first particles), and for liquid and
/// gas 1e-3 of the solids. Source: [kraaijevanger1991], embedded method [fekete2022].
class Integrator {
 public:
  Integrator(CompartmentRow& row, Exchange& exchange, const PbmCase& pbm_case, double last_error);

  struct Step {
    double taken = 0.0;  ///< [s]
    double next = 0.0;   ///< to try next [s]
  };
  /// Moves `state` on by at most `h`; `longest` is what the control wanted before an output time cut it (h <= longest).
  /// Collective. Errors: the tolerance cannot be kept with steps of at least `shortest`; names time, place and
  /// settings.
  Result<Step> step(std::span<double> state, double time, Inputs inputs, double h, double longest, double shortest);

  const WorkCount& work() const { return work_; }
  double last_error() const { return control_.last_error(); }

 private:
  enum class Verdict { fine, throttle, shorten };
  enum class Size : char { large, small, dust };
  struct Judgement {
    Verdict verdict = Verdict::fine;
    double error = 0.0;
    int worst_compartment = 0;
    int worst_quantity = 0;
  };
  bool slowed_down(std::span<const double> state, std::size_t x, std::size_t k, double h) const;
  bool emptied(std::span<const double> state, std::size_t x, std::size_t k, double h) const;
  double limit_by_emptying(std::span<const double> state, double h) const;
  double limit_by_filling(std::span<const double> state, double h) const;
  double smallest(double mine) const;
  double limit_first_stage(std::span<const double> state, Inputs inputs, double h);
  void run_stages(std::span<const double> state, Inputs inputs, double h);
  double next_step(double taken, double longest, bool was_cut, double error);
  Judgement judge(std::span<const double> state, double h);
  void check(std::span<const double> stage);
  void evaluate(std::span<const double> state, std::span<const double> participation, Inputs inputs, LaneVector& rates);
  void mark_small_classes(std::span<const double> state);
  Error too_hard(double time, double h, const Judgement& last) const;

  CompartmentRow* row_;
  Exchange* exchange_;
  std::size_t n_compartments_;
  double tolerance_;
  std::array<double, 4> brought_{};  ///< by feed and spray between two outputs: number, solid, liquid, gas
  StepControl control_;
  WorkCount work_;
  LaneVector f0_, f1_, f2_, f3_, stage_, new_state_;
  LaneVector first_rates_;          ///< f(state) with full participation
  LaneVector participation_;        ///< shape (compartments, n_classes); empty: 1 everywhere
  std::vector<Size> sizes_;         ///< what a class holds, shape (compartments, n_classes)
  std::vector<double> slow_down_;   ///< per compartment: 1 if a small class went negative in a stage
  std::vector<double> shorten_;     ///< per compartment: 1 if another did
  std::vector<double> first_loss_;  ///< loss rates that belong to first_rates_ [1/s], shape (compartments, n_classes)
};

}  // namespace granary::pbm
