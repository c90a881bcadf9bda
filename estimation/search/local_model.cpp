#include "estimation/search/local_model.hpp"

#include <algorithm>
#include <cmath>

namespace granary::estimation {

using Eigen::MatrixXd;
using Eigen::VectorXd;

LocalModel::LocalModel(const Known& centre, const std::vector<Known>& known, double reach)
    : centre_(vector_of(centre.at)),
      residuals_(vector_of(centre.residuals)),
      reach_(reach),
      design_(MatrixXd::Zero(centre_.size(), centre_.size())) {
  MatrixXd response = MatrixXd::Zero(residuals_.size(), centre_.size());
  for (const Known& k : known) {
    if (k.residuals.size() != centre.residuals.size()) continue;
    const VectorXd away = vector_of(k.at) - centre_;
    const double w = weight(away);
    if (w < 1e-6) continue;
    design_ += w * away * away.transpose();
    response += w * (vector_of(k.residuals) - residuals_) * away.transpose();
  }
  // A little ridge, so that a direction not yet looked into has slope 0 rather than none.
  const MatrixXd ridged = design_ + 1e-6 * reach_ * reach_ * MatrixXd::Identity(centre_.size(), centre_.size());
  jacobian_ = ridged.ldlt().solve(response.transpose()).transpose();
}

double LocalModel::weight(const VectorXd& away) const { return 1.0 / (1.0 + std::pow(away.norm() / reach_, 6)); }

std::optional<VectorXd> LocalModel::missing_direction(const std::vector<Trial>& planned) const {
  MatrixXd design = design_;
  for (const Trial& t : planned) {
    const VectorXd away = vector_of(t.at) - centre_;
    design += weight(away) * away * away.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(design);
  if (eigen.eigenvalues()[0] >= 0.2 * reach_ * reach_) return std::nullopt;
  return eigen.eigenvectors().col(0);
}

VectorXd LocalModel::step(double damping) const {
  const auto n = centre_.size();
  const MatrixXd normal = jacobian_.transpose() * jacobian_;
  const VectorXd slope = jacobian_.transpose() * residuals_;
  const double scale = std::max(normal.diagonal().maxCoeff(), 1e-300);
  std::vector<bool> free(static_cast<std::size_t>(n), true);
  VectorXd step = VectorXd::Zero(n);
  // Parameters that would leave through their bound stay on it, and the others are solved for anew.
  for (Eigen::Index rounds = 0; rounds <= n; ++rounds) {
    MatrixXd a = normal;
    VectorXd b = -slope;
    for (Eigen::Index i = 0; i < n; ++i) {
      a(i, i) += damping * (normal(i, i) + 1e-3 * scale);
      if (free[static_cast<std::size_t>(i)]) continue;
      b -= normal.col(i) * step[i];
      a.row(i).setZero();
      a.col(i).setZero();
      a(i, i) = 1.0;
      b[i] = step[i];
    }
    for (Eigen::Index i = 0; i < n; ++i)
      if (!free[static_cast<std::size_t>(i)]) b[i] = step[i];
    const VectorXd solved = a.ldlt().solve(b);
    bool left = false;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double to = centre_[i] + solved[i];
      if (free[static_cast<std::size_t>(i)] && (to < 0.0 || to > 1.0)) {
        free[static_cast<std::size_t>(i)] = false;
        step[i] = std::clamp(to, 0.0, 1.0) - centre_[i];
        left = true;
      }
    }
    if (left) continue;
    step = solved;
    break;
  }
  for (Eigen::Index i = 0; i < n; ++i) step[i] = std::clamp(centre_[i] + step[i], 0.0, 1.0) - centre_[i];
  return step;
}

double LocalModel::expected_gain(const VectorXd& step) const {
  return 0.5 * (residuals_.squaredNorm() - (residuals_ + jacobian_ * step).squaredNorm());
}

}  // namespace granary::estimation
