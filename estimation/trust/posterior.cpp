#include "estimation/trust/posterior.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "estimation/search/local_model.hpp"
#include "estimation/search/methods.hpp"

namespace granary::estimation {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kFreedom = 5.0;  // tails heavier than the posterior's, or rare samples would weigh too much
constexpr double kWiden = 1.2;    // for the same reason
// A third of the samples is drawn wider still: a posterior that bends or trails off would otherwise look narrow and
// well sampled.
constexpr double kWidenMore = 2.0;
constexpr double kWideShare = 0.3;
constexpr double kLeastSpread = 1e-6;

}  // namespace

struct Posterior::State {
  /// A t distribution; its density but for a constant that all of them share.
  struct Proposal {
    VectorXd mean;
    MatrixXd root;  ///< of its scale matrix, lower triangle
    double ln_volume = 0.0;
    double drawn = 0.0;

    Proposal(const VectorXd& about, const MatrixXd& covariance, double widen) : mean(about) {
      const MatrixXd wide =
          widen * widen * covariance + kLeastSpread * kLeastSpread * MatrixXd::Identity(about.size(), about.size());
      root = wide.llt().matrixL();
      ln_volume = root.diagonal().array().log().sum();
    }
    double density(const VectorXd& at) const {
      const double square = root.triangularView<Eigen::Lower>().solve(at - mean).squaredNorm();
      const double n = static_cast<double>(mean.size());
      return std::exp(-ln_volume - 0.5 * (kFreedom + n) * std::log1p(square / kFreedom));
    }
  };

  struct Sample {
    VectorXd at;
    double cost;
    double density = 0.0;  ///< of all proposals but the last pair, each times its draws
  };

  State(std::uint64_t seed, double by) : dice(seed), misfit(by) {}

  Dice dice;
  double misfit;
  std::vector<Proposal> proposals;  ///< in pairs: the wider one first
  MatrixXd spread;                  ///< covariance of the last pair
  std::vector<Sample> samples;
  std::vector<double> weights;
  std::size_t adapted_at = 0;
  bool stale = false;  ///< the weights are those of fewer samples

  /// Deterministic mixture: each sample is held against all proposals, in the share they were drawn from.
  void weigh() {
    if (!stale) return;
    stale = false;
    double least = 1e300;
    for (const Sample& s : samples) least = std::min(least, s.cost);
    weights.clear();
    for (const Sample& s : samples) {
      const double density = s.density + density_of(proposals.end() - 2, proposals.end(), s.at);
      weights.push_back(density > 0.0 ? std::exp((least - s.cost) / misfit) / density : 0.0);
    }
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    for (double& w : weights) w /= sum;
  }

  static double density_of(std::vector<Proposal>::const_iterator from, std::vector<Proposal>::const_iterator to,
                           const VectorXd& at) {
    double density = 0.0;
    for (; from != to; ++from) density += from->drawn * from->density(at);
    return density;
  }

  void propose(const VectorXd& mean, const MatrixXd& covariance) {
    // Nothing is drawn from the last pair any more.
    if (!proposals.empty())
      for (Sample& s : samples) s.density += density_of(proposals.end() - 2, proposals.end(), s.at);
    spread = covariance;
    proposals.emplace_back(mean, covariance, kWidenMore);
    proposals.emplace_back(mean, covariance, kWiden);
  }

  void adapt() {
    const Index n = proposals.front().mean.size();
    VectorXd mean = VectorXd::Zero(n);
    MatrixXd covariance = MatrixXd::Zero(n, n);
    for (std::size_t k = 0; k < samples.size(); ++k) mean += weights[k] * samples[k].at;
    for (std::size_t k = 0; k < samples.size(); ++k)
      covariance += weights[k] * (samples[k].at - mean) * (samples[k].at - mean).transpose();
    // Few samples that weigh would make it too narrow: what went before keeps a part in it.
    double squares = 0.0;
    for (const double w : weights) squares += w * w;
    const double trusted = std::min(1.0, 1.0 / squares / (10.0 * static_cast<double>(n)));
    propose(mean, trusted * covariance + (1.0 - trusted) * spread);
    adapted_at = samples.size();
  }
};

Posterior::Posterior(const Point& centre, const std::vector<std::vector<double>>& covariance, std::uint64_t seed,
                     double misfit)
    : state_(std::make_unique<State>(seed, misfit)) {
  const auto n = static_cast<Index>(centre.size());
  MatrixXd matrix(n, n);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j) matrix(i, j) = covariance[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  state_->propose(vector_of(centre), matrix);
}

Posterior::Posterior(Posterior&&) noexcept = default;
Posterior& Posterior::operator=(Posterior&&) noexcept = default;
Posterior::~Posterior() = default;

Point Posterior::ask() {
  const bool wide = state_->dice.uniform() < kWideShare;
  State::Proposal& from = *(state_->proposals.end() - (wide ? 2 : 1));
  const auto n = from.mean.size();
  for (;;) {
    from.drawn += 1.0;  // those outside too: the proposal's density is not cut off at the cube's faces
    VectorXd z(n);
    for (double& x : z) x = state_->dice.normal();
    double chi_square = 0.0;
    for (int k = 0; k < static_cast<int>(kFreedom); ++k) chi_square += std::pow(state_->dice.normal(), 2);
    const VectorXd at = from.mean + std::sqrt(kFreedom / chi_square) * (from.root * z);
    if (at.minCoeff() >= 0.0 && at.maxCoeff() <= 1.0) return {at.begin(), at.end()};
  }
}

void Posterior::tell(const Point& at, const std::optional<Residuals>& residuals) {
  if (residuals && cost_of(*residuals) < 1e300) {
    const auto& proposals = state_->proposals;
    const VectorXd x = vector_of(at);
    state_->samples.push_back({x, cost_of(*residuals), State::density_of(proposals.begin(), proposals.end() - 2, x)});
  }
  state_->stale = !state_->samples.empty();
  const auto batch = 40 + 10 * at.size();
  if (state_->samples.size() < state_->adapted_at + batch) return;
  state_->weigh();
  state_->adapt();
  state_->stale = true;
}

std::size_t Posterior::samples() const { return state_->samples.size(); }

double Posterior::effective_samples() const {
  state_->weigh();
  double squares = 0.0;
  for (const double w : state_->weights) squares += w * w;
  return squares > 0.0 ? 1.0 / squares : 0.0;
}

std::optional<Posterior::Interval> Posterior::interval(std::size_t parameter) const {
  const double effective = effective_samples();
  if (effective < 10.0) return std::nullopt;
  std::vector<std::pair<double, double>> values;
  for (std::size_t k = 0; k < state_->samples.size(); ++k)
    values.emplace_back(state_->samples[k].at[static_cast<Index>(parameter)], state_->weights[k]);
  std::sort(values.begin(), values.end());
  const auto quantile = [&](double q) {
    double sum = 0.0;
    for (const auto& [value, weight] : values) {
      sum += weight;
      if (sum >= q) return value;
    }
    return values.back().first;
  };
  const double tail = std::max(0.0, 0.025 - std::sqrt(0.025 * 0.975 / effective));
  return Interval{quantile(tail), quantile(1.0 - tail)};
}

}  // namespace granary::estimation
