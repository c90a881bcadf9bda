#include "estimation/search/search.hpp"

#include <algorithm>
#include <cmath>

#include "common/assert.hpp"
#include "estimation/search/methods.hpp"

namespace granary::estimation {

double cost_of(const Residuals& residuals) {
  double sum = 0.0;
  for (const double r : residuals) sum += r * r;
  return std::isfinite(sum) ? 0.5 * sum : 1e300;
}

Trial Search::ask() {
  waiting_.push_back({asked_++, next()});
  return waiting_.back();
}

void Search::tell(long trial, const std::optional<Residuals>& residuals) {
  const auto it = std::find_if(waiting_.begin(), waiting_.end(), [&](const Trial& t) { return t.number == trial; });
  if (it == waiting_.end()) return;
  const Point at = std::move(it->at);
  waiting_.erase(it);
  ++told_;
  const bool usable = residuals && cost_of(*residuals) < 1e300;
  if (usable && cost_of(*residuals) < best_.cost) best_ = {at, *residuals, cost_of(*residuals), trial};
  learn(at, usable ? residuals : std::nullopt);
}

void Search::inform(const Point& at, const Residuals& residuals) {
  if (cost_of(residuals) >= 1e300) return;
  if (cost_of(residuals) < best_.cost) best_ = {at, residuals, cost_of(residuals), -1};
  learn(at, residuals);
}

std::string name_of(Method method) {
  switch (method) {
    case Method::cma_es:
      return "cma-es";
    case Method::differential_evolution:
      return "differential-evolution";
    case Method::ensemble_kalman:
      return "ensemble-kalman";
    case Method::least_squares:
      return "least-squares";
    case Method::hybrid:
      return "hybrid";
  }
  return "";
}

std::unique_ptr<Search> make_search(Method method, int dimensions, std::uint64_t seed,
                                    const std::optional<Point>& start, bool near) {
  GRANARY_ASSERT(dimensions > 0);
  const Point from = start.value_or(Point(static_cast<std::size_t>(dimensions), 0.5));
  switch (method) {
    case Method::cma_es:
      return make_cma_es(from, seed);
    case Method::differential_evolution:
      return make_differential_evolution(from, seed);
    case Method::ensemble_kalman:
      return make_ensemble_kalman(from, seed);
    case Method::least_squares:
      return make_least_squares(from, seed);
    case Method::hybrid:
      return make_hybrid(from, seed, near);
  }
  return nullptr;
}

}  // namespace granary::estimation
