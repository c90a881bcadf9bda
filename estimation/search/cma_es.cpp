// Covariance matrix adaptation [N. Hansen, The CMA Evolution Strategy: A Tutorial, arXiv:1604.00772, 2016], without
// generations: whenever lambda results are there, whatever distribution they were drawn from, they make the next one.
// Those drawn from an older one are injected as foreign solutions, their length bounded [N. Hansen, Injecting external
// solutions into CMA-ES, INRIA RR-7748, 2011].
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "estimation/search/methods.hpp"

namespace granary::estimation {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class CmaEs final : public Search {
 public:
  CmaEs(const Point& start, std::uint64_t seed)
      : n_(static_cast<int>(start.size())),
        dice_(seed),
        lambda_(4 + static_cast<int>(3.0 * std::log(n_))),
        mean_(Eigen::Map<const VectorXd>(start.data(), n_)),
        covariance_(MatrixXd::Identity(n_, n_)),
        axes_(covariance_),
        lengths_(VectorXd::Ones(n_)),
        path_sigma_(VectorXd::Zero(n_)),
        path_c_(VectorXd::Zero(n_)) {
    const int parents = lambda_ / 2;
    for (int i = 0; i < parents; ++i) weights_.push_back(std::log(0.5 * (lambda_ + 1)) - std::log(i + 1.0));
    const double sum = std::accumulate(weights_.begin(), weights_.end(), 0.0);
    double squares = 0.0;
    for (double& w : weights_) {
      w /= sum;
      squares += w * w;
    }
    effective_ = 1.0 / squares;
  }

  std::string name() const override { return name_of(Method::cma_es); }
  bool converged() const override { return sigma_ * lengths_.maxCoeff() < 1e-4; }

 private:
  struct Result {
    VectorXd at;
    double cost;
  };

  Point next() override {
    VectorXd z(n_);
    for (double& x : z) x = dice_.normal();
    const VectorXd x = mean_ + sigma_ * (axes_ * lengths_.cwiseProduct(z));
    Point p(static_cast<std::size_t>(n_));
    for (int i = 0; i < n_; ++i) p[static_cast<std::size_t>(i)] = reflected(x[i]);
    return p;
  }

  void learn(const Point& at, const std::optional<Residuals>& residuals) override {
    results_.push_back({Eigen::Map<const VectorXd>(at.data(), n_), residuals ? cost_of(*residuals) : 1e300});
    if (static_cast<int>(results_.size()) < lambda_) return;
    std::stable_sort(results_.begin(), results_.end(),
                     [](const Result& a, const Result& b) { return a.cost < b.cost; });
    if (results_.front().cost < 1e300) adapt();
    results_.clear();
  }

  void adapt() {
    const double n = n_;
    const double c_sigma = (effective_ + 2.0) / (n + effective_ + 5.0);
    const double damping = 1.0 + 2.0 * std::max(0.0, std::sqrt((effective_ - 1.0) / (n + 1.0)) - 1.0) + c_sigma;
    const double c_c = (4.0 + effective_ / n) / (n + 4.0 + 2.0 * effective_ / n);
    const double c_1 = 2.0 / ((n + 1.3) * (n + 1.3) + effective_);
    const double c_mu =
        std::min(1.0 - c_1, 2.0 * (effective_ - 2.0 + 1.0 / effective_) / ((n + 2.0) * (n + 2.0) + effective_));
    const double expected = std::sqrt(n) * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));
    const double longest = std::sqrt(n) + 2.0 * n / (n + 2.0);

    const MatrixXd whitening = axes_ * lengths_.cwiseInverse().asDiagonal() * axes_.transpose();
    VectorXd step = VectorXd::Zero(n_);
    MatrixXd spread = MatrixXd::Zero(n_, n_);
    for (std::size_t i = 0; i < weights_.size(); ++i) {
      VectorXd y = (results_[i].at - mean_) / sigma_;
      const double length = (whitening * y).norm();
      if (length > longest) y *= longest / length;
      step += weights_[i] * y;
      spread += weights_[i] * y * y.transpose();
    }
    mean_ += sigma_ * step;
    for (double& x : mean_) x = std::clamp(x, 0.0, 1.0);
    path_sigma_ =
        (1.0 - c_sigma) * path_sigma_ + std::sqrt(c_sigma * (2.0 - c_sigma) * effective_) * (whitening * step);
    ++generation_;
    const double bias = std::sqrt(1.0 - std::pow(1.0 - c_sigma, 2.0 * generation_));
    const bool steady = path_sigma_.norm() / bias < (1.4 + 2.0 / (n + 1.0)) * expected;
    path_c_ = (1.0 - c_c) * path_c_;
    if (steady) path_c_ += std::sqrt(c_c * (2.0 - c_c) * effective_) * step;
    const double held = steady ? 0.0 : c_1 * c_c * (2.0 - c_c);
    covariance_ = (1.0 - c_1 - c_mu + held) * covariance_ + c_1 * path_c_ * path_c_.transpose() + c_mu * spread;
    sigma_ *= std::exp(std::min(1.0, (c_sigma / damping) * (path_sigma_.norm() / expected - 1.0)));
    sigma_ = std::min(sigma_, 0.5);  // the cube's own size: wider only draws mirrored points

    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(covariance_);
    axes_ = eigen.eigenvectors();
    lengths_ = eigen.eigenvalues().cwiseMax(1e-20).cwiseSqrt();
  }

  int n_;
  Dice dice_;
  int lambda_;
  double sigma_ = 0.3;
  VectorXd mean_;
  MatrixXd covariance_, axes_;
  VectorXd lengths_, path_sigma_, path_c_;
  std::vector<double> weights_;
  double effective_ = 1.0;  ///< mu_eff
  int generation_ = 0;
  std::vector<Result> results_;
};

}  // namespace

std::unique_ptr<Search> make_cma_es(const Point& start, std::uint64_t seed) {
  return std::make_unique<CmaEs>(start, seed);
}

}  // namespace granary::estimation
