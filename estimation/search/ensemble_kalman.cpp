// Ensemble Kalman inversion [M. A. Iglesias, K. J. H. Law, A. M. Stuart, Inverse Problems 29 (2013) 045001], member by
// member: each moves as soon as its own result is there, by the covariances of the ensemble as it is then. The data's
// weight grows as the misfit falls [M. Iglesias, Y. Yang, Inverse Problems 37 (2021) 025008].
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <deque>

#include "estimation/search/methods.hpp"

namespace granary::estimation {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class EnsembleKalman final : public Search {
 public:
  EnsembleKalman(const Point& start, std::uint64_t seed)
      : n_(start.size()), dice_(seed), most_(std::max<std::size_t>(24, 8 * n_)), first_(start) {}

  std::string name() const override { return name_of(Method::ensemble_kalman); }

  bool converged() const override {
    if (members_.size() < most_) return false;
    for (std::size_t d = 0; d < n_; ++d) {
      double mean = 0.0, square = 0.0;
      for (const Member& m : members_) mean += m.at[d], square += m.at[d] * m.at[d];
      mean /= static_cast<double>(members_.size());
      if (square / static_cast<double>(members_.size()) - mean * mean > 1e-6) return false;
    }
    return true;
  }

 private:
  struct Member {
    Point at;
    Residuals residuals;
  };

  Point next() override {
    if (!due_.empty()) {
      Point p = due_.front();
      due_.pop_front();
      return p;
    }
    if (sown_ < most_ || members_.size() < 2) return sown_++ == 0 ? first_ : dice_.anywhere(n_);
    // All members are being evaluated: a further one, between two of them.
    const auto pick = [&] { return static_cast<std::size_t>(dice_.below(static_cast<int>(members_.size()))); };
    const Point &a = members_[pick()].at, &b = members_[pick()].at;
    Point p(n_);
    for (std::size_t d = 0; d < n_; ++d) p[d] = a[d] + dice_.uniform() * (b[d] - a[d]);
    return p;
  }

  void learn(const Point& at, const std::optional<Residuals>& residuals) override {
    if (!residuals) {
      due_.push_back(members_.size() < most_ ? dice_.anywhere(n_) : members_[turn_++ % members_.size()].at);
      return;
    }
    if (members_.size() < most_) {
      members_.push_back({at, *residuals});
      if (members_.size() == most_)
        for (Member& m : members_) due_.push_back(moved(m));
      return;
    }
    // The newcomer takes the place of the oldest.
    members_[turn_++ % members_.size()] = {at, *residuals};
    due_.push_back(moved(members_[(turn_ - 1) % members_.size()]));
  }

  Point moved(const Member& member) {
    const auto n = static_cast<Eigen::Index>(n_), data = static_cast<Eigen::Index>(member.residuals.size());
    const auto size = static_cast<Eigen::Index>(members_.size());
    MatrixXd at(n, size), fit(data, size);
    for (Eigen::Index k = 0; k < size; ++k) {
      const Member& m = members_[static_cast<std::size_t>(k)];
      at.col(k) = Eigen::Map<const VectorXd>(m.at.data(), n);
      if (static_cast<Eigen::Index>(m.residuals.size()) != data) return member.at;
      fit.col(k) = Eigen::Map<const VectorXd>(m.residuals.data(), data);
    }
    std::vector<double> costs;
    for (const Member& m : members_) costs.push_back(2.0 * cost_of(m.residuals) / static_cast<double>(data));
    std::nth_element(costs.begin(), costs.begin() + size / 2, costs.end());
    const double alpha = std::max(1.0, costs[static_cast<std::size_t>(size / 2)]);
    const VectorXd mean = fit.rowwise().mean();
    at.colwise() -= at.rowwise().mean().eval();
    fit.colwise() -= mean;
    // C_ur (C_rr + alpha)^{-1} v through the ensemble: (F F^T + a)^{-1} = (1 - F (a + F^T F)^{-1} F^T) / a.
    const double a = alpha * static_cast<double>(size - 1);
    VectorXd wanted(data);
    for (Eigen::Index i = 0; i < data; ++i)
      wanted[i] = std::sqrt(alpha) * dice_.normal() - member.residuals[static_cast<std::size_t>(i)];
    const MatrixXd inner = a * MatrixXd::Identity(size, size) + fit.transpose() * fit;
    const VectorXd solved = (wanted - fit * inner.ldlt().solve(fit.transpose() * wanted)) / a;
    const VectorXd step = at * (fit.transpose() * solved);
    Point to = member.at;
    for (std::size_t d = 0; d < n_; ++d) to[d] = reflected(to[d] + step[static_cast<Eigen::Index>(d)]);
    return to;
  }

  std::size_t n_;
  Dice dice_;
  std::size_t most_, sown_ = 0, turn_ = 0;
  Point first_;
  std::vector<Member> members_;
  std::deque<Point> due_;
};

}  // namespace

std::unique_ptr<Search> make_ensemble_kalman(const Point& start, std::uint64_t seed) {
  return std::make_unique<EnsembleKalman>(start, seed);
}

}  // namespace granary::estimation
