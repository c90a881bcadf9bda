// Levenberg and Marquardt [J. J. Moré, Lecture Notes in Mathematics 630 (1978) 105] with Jacobians by regression over
// what was evaluated near by, so that many cores can be busy at once: those that do not try a step, of several
// dampings, look into directions that the regression knows least of.
#include <algorithm>
#include <cmath>

#include "estimation/search/local_model.hpp"
#include "estimation/search/methods.hpp"

namespace granary::estimation {
namespace {

using Eigen::VectorXd;

constexpr double kLeastReach = 4e-3;  // differences over less drown in the solver's own tolerance

class LeastSquares final : public Search {
 public:
  LeastSquares(const Point& start, std::uint64_t seed, double step)
      : n_(start.size()), dice_(seed), start_(start), reach_(step) {}

  std::string name() const override { return name_of(Method::least_squares); }
  bool converged() const override { return converged_; }

 private:
  Point next() override {
    if (known_.empty()) return asked() == 1 ? start_ : around(start_, 4.0 * reach_);
    const LocalModel model(centre(), known_, reach_);
    if (const auto direction = model.missing_direction(pending())) return along(*direction);
    if (model.missing_direction({})) return around(centre().at, reach_);
    // Steps that are tried at the same time differ in their damping: 1, 1/10, 10, 1/100, ... times the current one.
    int tried = 0;
    for (const Step& s : steps_) tried += s.from == centre_;
    const int tenfold = (tried + 1) / 2;
    const double power = tried % 2 == 1 ? -tenfold : tenfold;
    if (tried > 6) return around(centre().at, reach_);
    const VectorXd step = model.step(damping_ * std::pow(10.0, power));
    if (tried == 0 && model.expected_gain(step) < 1e-3 * std::max(1.0, best().cost)) {
      if (reach_ <= 4.0 * kLeastReach || step.norm() < kLeastReach) converged_ = true;
      reach_ = std::max(kLeastReach, 0.5 * reach_);
    }
    if (step.norm() < 1e-3 * kLeastReach) return around(centre().at, reach_);
    steps_.push_back({moved(centre().at, step), centre_, step.norm()});
    return steps_.back().to;
  }

  void learn(const Point& at, const std::optional<Residuals>& residuals) override {
    const auto step = std::find_if(steps_.begin(), steps_.end(), [&](const Step& s) { return s.to == at; });
    const bool better =
        residuals && (known_.empty() || cost_of(*residuals) < cost_of(centre().residuals) * (1.0 - 1e-9));
    if (residuals) known_.push_back({at, *residuals});
    if (better) {
      centre_ = known_.size() - 1;
      converged_ = false;
    }
    if (step == steps_.end()) return;
    if (better) {
      damping_ = std::max(1e-8, damping_ / 5.0);
      reach_ = std::clamp(0.5 * step->length, kLeastReach, 2.0 * reach_);
    } else {
      damping_ = std::min(1e8, 3.0 * damping_);
      reach_ = std::max(kLeastReach, 0.7 * reach_);
    }
    steps_.erase(step);
  }

  struct Step {
    Point to;
    std::size_t from;
    double length;
  };

  const Known& centre() const { return known_[centre_]; }

  Point moved(const Point& from, const VectorXd& by) const {
    Point to = from;
    for (std::size_t i = 0; i < n_; ++i) to[i] = std::clamp(to[i] + by[static_cast<Eigen::Index>(i)], 0.0, 1.0);
    return to;
  }

  /// To the side on which there is room.
  Point along(VectorXd direction) {
    const Point& c = centre().at;
    double room = 0.0;
    for (std::size_t i = 0; i < n_; ++i) {
      const double d = direction[static_cast<Eigen::Index>(i)];
      room += d * (0.5 - c[i]);
    }
    if (room < 0.0 || (std::abs(room) < 0.1 && dice_.uniform() < 0.5)) direction = -direction;
    return moved(c, reach_ * direction);
  }

  Point around(const Point& from, double how_far) {
    VectorXd away(static_cast<Eigen::Index>(n_));
    for (double& x : away) x = dice_.normal();
    Point p = from;
    for (std::size_t i = 0; i < n_; ++i)
      p[i] = reflected(p[i] + how_far * away[static_cast<Eigen::Index>(i)] / away.norm());
    return p;
  }

  std::size_t n_;
  Dice dice_;
  Point start_;
  double reach_, damping_ = 1e-2;
  std::vector<Known> known_;
  std::size_t centre_ = 0;   ///< the best of them
  std::vector<Step> steps_;  ///< asked for and not yet told of
  bool converged_ = false;
};

}  // namespace

std::unique_ptr<Search> make_least_squares(const Point& start, std::uint64_t seed, double step) {
  return std::make_unique<LeastSquares>(start, seed, step);
}

}  // namespace granary::estimation
