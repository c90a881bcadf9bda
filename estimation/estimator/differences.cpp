#include "estimation/estimator/differences.hpp"

#include <utility>

namespace granary::estimation {
namespace {

// In the unit cube: wide beside what the solver's own tolerance moves, narrow beside the intervals that matter.
constexpr double kStep = 0.01;
constexpr std::size_t kRest = 2;  // rounds without a question after each round of questions

}  // namespace

Differences::Differences(Point centre, Residuals at, double cost)
    : centre_(std::move(centre)),
      at_(std::move(at)),
      cost_(cost),
      points_(difference_points(centre_, kStep)),
      around_(points_.size()),
      failures_(points_.size(), 0) {
  for (std::size_t k = 0; k < points_.size(); ++k)
    if (points_[k] == centre_) around_[k] = at_;  // at a bound
}

bool Differences::is(long k, const Point& at) const {
  return k >= 0 && static_cast<std::size_t>(k) < points_.size() && points_[static_cast<std::size_t>(k)] == at;
}

std::optional<std::size_t> Differences::next() {
  while (turn_ < points_.size()) {
    const std::size_t k = turn_++;
    if (!settled(k)) return k;
  }
  turn_ = turn_ + 1 < (1 + kRest) * points_.size() ? turn_ + 1 : 0;
  return std::nullopt;
}

void Differences::tell(long k, const std::optional<Residuals>& residuals) {
  const auto index = static_cast<std::size_t>(k);
  if (!around_[index].empty()) return;
  if (residuals)
    around_[index] = *residuals;
  else
    ++failures_[index];
}

bool Differences::complete() const {
  for (std::size_t k = 0; k < points_.size(); ++k)
    if (!settled(k)) return false;
  return true;
}

Uncertainty Differences::uncertainty() const {
  // A parameter whose differences all failed: as if the residuals did not depend on it.
  std::vector<Residuals> around = around_;
  for (std::size_t i = 0; i + 1 < around.size(); i += 2)
    if (around[i].empty() && around[i + 1].empty()) around[i] = around[i + 1] = at_;
  return uncertainty_of(centre_, at_, around, kStep).value();
}

}  // namespace granary::estimation
