// Ensemble Kalman inversion [M. A. Iglesias, K. J. H. Law, A. M. Stuart, Inverse Problems 29 (2013) 045001], member by
// member: each moves as soon as its own result is there, by the covariances of the ensemble as it is then. The data's
// weight grows as the misfit falls [M. Iglesias, Y. Yang, Inverse Problems 37 (2021) 025008].
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <deque>

#include "common/math/percentile.hpp"
#include "estimation/search/local_model.hpp"
#include "estimation/search/population.hpp"

namespace granary::estimation {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kPatience = 3;  // ensembles in a row whose median cost is no better than the best before them

class EnsembleKalman final : public Population {
 public:
  EnsembleKalman(const Point& start, std::uint64_t seed)
      : Population(start, seed, std::max<std::size_t>(24, 8 * start.size())) {}

  std::string name() const override { return name_of(Method::ensemble_kalman); }

  // An ensemble with noise of its own stays as wide as the data leave it: it is the cost that comes to rest, that of
  // the median member, since a lucky first throw may stay the best for long.
  bool converged() const override { return full() && turn_ > improved_at_ + kPatience * most_; }

 private:
  Point next() override {
    if (!due_.empty()) {
      Point p = due_.front();
      due_.pop_front();
      return p;
    }
    if (!sown(2)) return sow();
    // All members are being evaluated: a further one, between two of them.
    const Point &a = any().at, &b = any().at;
    Point p(n_);
    for (std::size_t d = 0; d < n_; ++d) p[d] = a[d] + dice_.uniform() * (b[d] - a[d]);
    return p;
  }

  void learn(const Point& at, const std::optional<Residuals>& residuals) override {
    if (!residuals) {
      due_.push_back(full() ? members_[turn_++ % members_.size()].at : dice_.anywhere(n_));
      return;
    }
    const Member member{at, *residuals, cost_of(*residuals)};
    if (!full()) {
      members_.push_back(member);
      if (full())
        for (const Member& m : members_) due_.push_back(moved(m));
    } else {
      // The newcomer takes the place of the oldest.
      members_[turn_++ % members_.size()] = member;
      due_.push_back(moved(member));
    }
    if (full() && turn_ >= next_look_) {
      std::vector<double> costs;
      for (const Member& m : members_) costs.push_back(m.cost);
      const double middle = median(costs);
      if (middle < least_ - 1e-3 * std::max(1.0, middle)) least_ = middle, improved_at_ = turn_;
      next_look_ = turn_ + most_;
    }
  }

  Point moved(const Member& member) {
    const auto n = static_cast<Eigen::Index>(n_), data = static_cast<Eigen::Index>(member.residuals.size());
    const auto size = static_cast<Eigen::Index>(members_.size());
    MatrixXd at(n, size), fit(data, size);
    std::vector<double> misfits;
    for (Eigen::Index k = 0; k < size; ++k) {
      const Member& m = members_[static_cast<std::size_t>(k)];
      if (static_cast<Eigen::Index>(m.residuals.size()) != data) return member.at;
      at.col(k) = vector_of(m.at);
      fit.col(k) = vector_of(m.residuals);
      misfits.push_back(2.0 * m.cost / static_cast<double>(data));
    }
    const double alpha = std::max(1.0, median(misfits));
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

  double least_ = 1e300;                         ///< median cost of an ensemble so far,
  std::size_t next_look_ = 0, improved_at_ = 0;  ///< since this turn
  std::deque<Point> due_;
};

}  // namespace

std::unique_ptr<Search> make_ensemble_kalman(const Point& start, std::uint64_t seed) {
  return std::make_unique<EnsembleKalman>(start, seed);
}

}  // namespace granary::estimation
