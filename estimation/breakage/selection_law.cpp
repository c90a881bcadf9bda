#include "estimation/breakage/selection_law.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

namespace granary::estimation {
namespace {

constexpr double kNormal95 = 1.959963984540054;
constexpr int kMostIterations = 100;

double chi_squared_quantile(double degrees, double share) {
  return boost::math::quantile(boost::math::chi_squared(degrees), share);
}

}  // namespace

Rate rate_of(long events, double exposure) {
  if (!(exposure > 0.0)) return {std::nan(""), 0.0, std::nan("")};
  const auto n = static_cast<double>(events);
  const double low = events > 0 ? 0.5 * chi_squared_quantile(2.0 * n, 0.025) : 0.0;
  return {n / exposure, low / exposure, 0.5 * chi_squared_quantile(2.0 * n + 2.0, 0.975) / exposure};
}

Rate SelectionLaw::at(const std::vector<double>& features) const {
  double mean = 0.0, variance = 0.0;
  for (std::size_t j = 0; j < coefficient.size(); ++j) {
    mean += coefficient[j] * features[j];
    for (std::size_t k = 0; k < coefficient.size(); ++k) variance += features[j] * covariance[j][k] * features[k];
  }
  const double spread = kNormal95 * std::sqrt(std::max(0.0, variance));
  return {std::exp(mean), std::exp(mean - spread), std::exp(mean + spread)};
}

Result<SelectionLaw> fit_selection_law(const std::vector<CountedEvents>& counts, double prior) {
  const auto n = static_cast<Eigen::Index>(counts.size());
  const auto m = static_cast<Eigen::Index>(counts.empty() ? 0 : counts.front().features.size());
  if (n == 0 || m == 0 || (n < m && std::isinf(prior)))
    return Error{fmt::format("{} counts are too few for a law of {} coefficients.", n, m)};
  Eigen::MatrixXd x(n, m);
  Eigen::VectorXd events(n), exposure(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const CountedEvents& one = counts[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < m; ++j) x(i, j) = one.features[static_cast<std::size_t>(j)];
    events(i) = one.events;
    exposure(i) = one.exposure;
  }
  if (!(events.sum() > 0.0)) return Error{"nothing broke: there is no rate to fit."};

  // From counts that are a little above none: then every logarithm is there.
  Eigen::VectorXd eta = ((events.array() + 0.1) / exposure.array()).log().matrix();
  Eigen::VectorXd c = Eigen::VectorXd::Zero(m), mean(n);
  Eigen::MatrixXd information(m, m);
  Eigen::VectorXd penalty = Eigen::VectorXd::Constant(m, 1.0 / (prior * prior));
  penalty(0) = 0.0;
  const Eigen::MatrixXd penalties = penalty.asDiagonal();
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    mean = (exposure.array() * eta.array().min(50.0).max(-50.0).exp()).matrix();
    const Eigen::VectorXd z = eta + ((events - mean).array() / mean.array()).matrix();
    information = x.transpose() * mean.asDiagonal() * x + penalties;
    Eigen::FullPivLU<Eigen::MatrixXd> solver(information);
    solver.setThreshold(1e-10);
    if (solver.rank() < m)
      return Error{"the counts do not tell the coefficients of the law apart. Vary more settings."};
    const Eigen::VectorXd next = solver.solve(x.transpose() * mean.asDiagonal() * z);
    const double change = (next - c).cwiseAbs().maxCoeff();
    c = next;
    eta = x * c;
    if (change < 1e-10) break;
  }
  mean = (exposure.array() * eta.array().exp()).matrix();
  information = x.transpose() * mean.asDiagonal() * x + penalties;
  const double pearson = ((events - mean).array().square() / mean.array()).sum();
  SelectionLaw law;
  law.dispersion = n > m ? std::max(1.0, pearson / static_cast<double>(n - m)) : 1.0;
  const Eigen::MatrixXd covariance = law.dispersion * information.inverse();
  law.covariance.assign(static_cast<std::size_t>(m), std::vector<double>(static_cast<std::size_t>(m)));
  for (Eigen::Index j = 0; j < m; ++j) {
    law.coefficient.push_back(c(j));
    for (Eigen::Index k = 0; k < m; ++k)
      law.covariance[static_cast<std::size_t>(j)][static_cast<std::size_t>(k)] = covariance(j, k);
  }
  return law;
}

}  // namespace granary::estimation
