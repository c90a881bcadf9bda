// Residuals near a centre as a linear function, by regression over the points evaluated so far: a Jacobian that costs
// no evaluations of its own where there are enough, and that says where one is missing.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "estimation/search/search.hpp"

namespace granary::estimation {

struct Known {
  Point at;
  Residuals residuals;
};

/// As Eigen has it.
inline Eigen::VectorXd vector_of(const std::vector<double>& v) {
  return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

class LocalModel {
 public:
  /// r(x) = r(centre) + J (x - centre), weighted least squares over `known` with weight 1 / (1 + (|x - centre| /
  /// reach)^6).
  LocalModel(const Known& centre, const std::vector<Known>& known, double reach);

  const Eigen::MatrixXd& jacobian() const { return jacobian_; }  ///< shape (data, parameters)
  const Eigen::VectorXd& residuals() const { return residuals_; }

  /// The direction in which the fewest points were evaluated, `planned` ones counted too. Nothing: all are well
  /// covered.
  std::optional<Eigen::VectorXd> missing_direction(const std::vector<Trial>& planned) const;
  /// The step of Levenberg and Marquardt that stays within the unit cube, damped by `damping` times the diagonal.
  Eigen::VectorXd step(double damping) const;
  /// By how much the cost falls over that step, if the model is right.
  double expected_gain(const Eigen::VectorXd& step) const;

 private:
  double weight(const Eigen::VectorXd& away) const;

  Eigen::VectorXd centre_, residuals_;
  double reach_;
  Eigen::MatrixXd design_, jacobian_;
};

}  // namespace granary::estimation
