// How long the next step may be, from the error of the last ones.
#pragma once

namespace granary::pbm {

/// A proportional-integral controller for an error estimate of order 3 in the step. An error of 1 is just allowed.
///   h_next = h 0.9 error^(-0.7/3) previous^(0.4/3), within [0.2, 3] h
/// Source: [hairer1996], section IV.2.
class StepControl {
 public:
  explicit StepControl(double last_error) : last_error_(last_error) {}
  /// Factor on the step after an accepted step, at most `most`; remembers the error.
  double accepted(double error, double most);
  /// Factor on the step after a rejected one: < 1.
  static double rejected(double error);
  double last_error() const { return last_error_; }

 private:
  double last_error_;
};

}  // namespace granary::pbm
