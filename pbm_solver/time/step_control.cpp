#include "pbm_solver/time/step_control.hpp"

#include <algorithm>
#include <cmath>

namespace granary::pbm {
namespace {

constexpr double kOrder = 3.0;
constexpr double kSafety = 0.9;
constexpr double kLeast = 0.2;
constexpr double kTinyError = 1e-4;

}  // namespace

double StepControl::accepted(double error, double most) {
  const double e = std::max(error, kTinyError);
  const double factor = kSafety * std::pow(e, -0.7 / kOrder) * std::pow(last_error_, 0.4 / kOrder);
  last_error_ = e;
  return std::clamp(factor, kLeast, most);
}

double StepControl::rejected(double error) {
  return std::isfinite(error) ? std::clamp(kSafety * std::pow(error, -1.0 / kOrder), kLeast, kSafety) : kLeast;
}

}  // namespace granary::pbm
