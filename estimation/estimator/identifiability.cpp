#include "estimation/estimator/identifiability.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace granary::estimation {
namespace {

constexpr double kSmall = 0.15;     // of the largest part of a direction: a part below it is left out
constexpr double kShownStep = 0.2;  // of the unit cube

struct Part {
  const Parameter* parameter;
  double along;  ///< part of the direction, unit cube
};

/// Along the direction the logarithms of the two change by these, so first x second^exponent does not change.
std::string power_law(const Part& first, const Part& second) {
  const auto decades = [](const Part& p) { return p.along * std::log10(p.parameter->high / p.parameter->low); };
  const double exponent = -decades(first) / decades(second);
  const std::string &a = first.parameter->name, &b = second.parameter->name;
  if (std::abs(exponent - 1.0) < 0.1) return fmt::format("Only the product of {} and {} is known", a, b);
  if (std::abs(exponent + 1.0) < 0.1) return fmt::format("Only the ratio of {} and {} is known", a, b);
  return fmt::format("Only {} times {} to the power {:.2g} is known", a, b, exponent);
}

std::string change_of(const Part& part) {
  const Parameter& p = *part.parameter;
  const double step = kShownStep * part.along;
  if (p.scale == Scale::linear) return fmt::format("{} {:+.3g}", p.name, step * (p.high - p.low));
  const double factor = std::pow(p.high / p.low, std::abs(step));
  return fmt::format("{} {} {:.3g}", p.name, step > 0.0 ? "times" : "divided by", factor);
}

}  // namespace

std::string sentence_of(const Unidentified& combination, const std::vector<Parameter>& parameters) {
  double largest = 0.0;
  for (const double x : combination.direction) largest = std::max(largest, std::abs(x));
  std::vector<Part> parts;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (std::abs(combination.direction[k]) > kSmall * largest)
      parts.push_back({&parameters[k], combination.direction[k]});
  if (parts.size() == 1) {
    const Parameter& p = *parts[0].parameter;
    return fmt::format(
        "The data say next to nothing of {}: whatever lies between {:g} and {:g} fits about as well. Fix it, or give "
        "it a prior.",
        p.name, p.low, p.high);
  }
  if (parts.size() == 2 && parts[0].parameter->scale == Scale::log && parts[1].parameter->scale == Scale::log)
    return power_law(parts[0], parts[1]) + ": the data cannot tell the two apart. Fix one of them, or give it a prior.";
  std::string changes;
  for (const Part& part : parts) changes += (changes.empty() ? "" : ", ") + change_of(part);
  return fmt::format(
      "The data cannot tell these apart: {}, all together, fits about as well. Fix some, or give priors.", changes);
}

}  // namespace granary::estimation
