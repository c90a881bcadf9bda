// One error-controlled step of the row of compartments: conservative, nothing clipped, explicit or partly implicit.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/result.hpp"
#include "pbm_solver/time/additive_method.hpp"
#include "pbm_solver/time/compartment_row.hpp"
#include "pbm_solver/time/exchange.hpp"
#include "pbm_solver/time/small_classes.hpp"
#include "pbm_solver/time/state_passes.hpp"
#include "pbm_solver/time/step_control.hpp"
#include "pbm_solver/time/stiff_part.hpp"

namespace granary::pbm {

/// What granary-pbm ends with when a run cannot keep its tolerance (docs/exchange_formats.md).
inline constexpr Exit kToleranceNotKept = static_cast<Exit>(20);

struct WorkCount {
  std::int64_t steps = 0;
  std::int64_t implicit_steps = 0;  ///< of these, those that took the stiff part implicitly
  std::int64_t rejected = 0;
  std::int64_t rhs_evaluations = 0;
};

/// Each step is taken with one of two methods of order 3 with 4 evaluations (additive_method.hpp): the explicit one,
/// or, where classes break or leave the grid faster than it could follow, the one that takes these two implicitly
/// (stiff_part.hpp). The choice follows from state and step alone.
///
/// Nothing is ever clipped. Small classes that are faster than the step in what is explicit are slowed down
/// (small_classes.hpp); a step that would still empty a class is repeated shorter. In a stage, implicit decay may lead
/// below 0 by a tenth of the tolerance of what a compartment holds, never at the end of a step. Kernels in low-rank
/// form are known only to a tolerance and bear values below 0: these may come to that tenth in either.
///
/// Error norm: the largest, over compartments and over {number, solid volume, liquid, gas}, of the sum of absolute
/// errors over the sum held there, relative to the tolerance. To what is held come 1e-3 of the row's mean and of what
/// feed and spray bring between two outputs (a start from empty, a spray onto the first particles), and for liquid and
/// gas 1e-3 of the solids.
class Integrator {
 public:
  Integrator(CompartmentRow& row, Exchange& exchange, const PbmCase& pbm_case, double last_error, int threads);

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
  struct Judgement {
    Verdict verdict = Verdict::fine;
    double error = 0.0;
    int worst_compartment = 0;
    int worst_quantity = 0;
  };
  void begin(std::span<const double> state, Inputs inputs, double h);
  double limit_first_stage(std::span<const double> state, Inputs inputs, double h);
  void run_stages(std::span<const double> state, Inputs inputs, double h);
  void take_stage(std::span<const double> state, std::size_t stage, double h);
  void estimate_error(double h);
  void evaluate(std::span<const double> state, std::span<const double> participation, Inputs inputs, LaneVector& rates);
  Judgement judge();
  double smallest(double mine) const;
  double next_step(double taken, double longest, bool was_cut, double error);
  Error too_hard(double time, double h, const Judgement& last) const;

  CompartmentRow* row_;
  Exchange* exchange_;
  std::size_t n_compartments_;
  int threads_;
  double tolerance_;
  bool born_negative_;  ///< births may be below 0: the kernel is known only to its tolerance
  Held brought_{};      ///< by feed and spray between two outputs
  StepControl control_;
  WorkCount work_;
  AdditiveMethod explicit_, implicit_explicit_;
  const AdditiveMethod* method_;  ///< of the present step
  SmallClasses small_;
  StiffPart stiff_;
  std::array<LaneVector, AdditiveMethod::kMost> e_, b_;  ///< E and B y of the stages
  LaneVector first_rates_;                               ///< E(state) with full participation
  LaneVector stage_, right_hand_side_, error_;
  std::vector<SmallClasses::Negative> negative_;  ///< by compartment of this rank
  std::vector<Held> before_, after_, off_;        ///< held at the start and the end of the step, error; likewise
};

}  // namespace granary::pbm
