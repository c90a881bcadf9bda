#include "estimation/trust/uncertainty.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

namespace granary::estimation {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kCubePrecision = 12.0;      // 1 / variance of a uniform number in [0, 1]
constexpr double kUnidentifiedLength = 0.5;  // half the cube: the data say next to nothing
constexpr double kInterval = 1.959964;       // 95 % of a normal distribution

std::vector<std::vector<double>> rows_of(const MatrixXd& m) {
  std::vector<std::vector<double>> rows(static_cast<std::size_t>(m.rows()));
  for (Index i = 0; i < m.rows(); ++i)
    for (Index j = 0; j < m.cols(); ++j) rows[static_cast<std::size_t>(i)].push_back(m(i, j));
  return rows;
}

}  // namespace

double mean_square_by_chance(std::size_t n) {
  const auto data = static_cast<double>(n);
  return boost::math::quantile(boost::math::chi_squared(data), 0.95) / data;
}

std::vector<Point> difference_points(const Point& centre, double step) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < centre.size(); ++i)
    for (const double side : {-1.0, 1.0}) {
      points.push_back(centre);
      const double to = centre[i] + side * step;
      if (to >= 0.0 && to <= 1.0) points.back()[i] = to;
    }
  return points;
}

Result<Uncertainty> uncertainty_of(const Point& centre, const Residuals& at, const std::vector<Residuals>& around,
                                   double step) {
  const auto n = static_cast<Index>(centre.size()), data = static_cast<Index>(at.size());
  const std::vector<Point> points = difference_points(centre, step);
  MatrixXd jacobian(data, n);
  for (Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool below = around[2 * k].size() == at.size(), above = around[2 * k + 1].size() == at.size();
    const Residuals &low = below ? around[2 * k] : at, &high = above ? around[2 * k + 1] : at;
    const double width = (above ? points[2 * k + 1][k] : centre[k]) - (below ? points[2 * k][k] : centre[k]);
    if (!(width > 0.0))
      return Error{fmt::format("the model failed on both sides of parameter {}: no interval can be given", i)};
    for (Index d = 0; d < data; ++d)
      jacobian(d, i) = (high[static_cast<std::size_t>(d)] - low[static_cast<std::size_t>(d)]) / width;
  }

  Uncertainty u;
  const double misfit = 2.0 * cost_of(at);
  u.chi_square_per_datum = misfit / static_cast<double>(std::max<Index>(data - n, 1));
  const MatrixXd information = jacobian.transpose() * jacobian / std::max(1.0, u.chi_square_per_datum);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(information);
  for (Index i = 0; i < n; ++i) {
    const double length = 1.0 / std::sqrt(std::max(eigen.eigenvalues()[i], 1e-12));
    if (length < kUnidentifiedLength) continue;
    const VectorXd v = eigen.eigenvectors().col(i);
    u.unidentified.push_back({{v.begin(), v.end()}, length});
  }
  const MatrixXd covariance = (information + kCubePrecision * MatrixXd::Identity(n, n)).inverse();
  const VectorXd deviation = covariance.diagonal().cwiseSqrt();
  u.covariance = rows_of(covariance);
  u.correlation = rows_of(deviation.cwiseInverse().asDiagonal() * covariance * deviation.cwiseInverse().asDiagonal());
  for (Index i = 0; i < n; ++i) {
    const double c = centre[static_cast<std::size_t>(i)], half = kInterval * deviation[i];
    u.deviation.push_back(deviation[i]);
    u.low.push_back(std::max(0.0, c - half));
    u.high.push_back(std::min(1.0, c + half));
    u.at_bound.push_back(c - half < 0.0 || c + half > 1.0);
  }
  return u;
}

}  // namespace granary::estimation
