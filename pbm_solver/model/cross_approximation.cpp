#include "pbm_solver/model/cross_approximation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace granary::pbm {
namespace {

constexpr int kStrides = 32;        // of the sample: pairs per class
constexpr double kNothing = 1e-14;  // a pivot of the scaled kernel that is round-off

/// What is left of the kernel, scaled by 1 / sqrt(C_kk C_mm) to keep its numbers near 1; errors are judged against
/// C_km.
class Cross {
 public:
  Cross(const PairKernel& kernel, const ParticleTable& particles, std::size_t n)
      : kernel_(&kernel), particles_(&particles), n_(n), scale_(n), diagonal_(n) {
    for (std::size_t k = 0; k < n; ++k) scale_[k] = std::sqrt(collisions(k, k));
    for (std::size_t k = 0; k < n; ++k) diagonal_[k] = entry(k, k);
    // Each class meets others at strides spread by the golden ratio; the smallest and the largest class meet all, for
    // the dry end and the fast end of a kernel are where it bends most.
    for (int stride = 0; stride < kStrides; ++stride)
      for (std::size_t k = 0; k < n; ++k) {
        const double part = std::fmod(0.6180339887498949 * stride, 1.0);
        look_at(k, (k + 1 + static_cast<std::size_t>(part * static_cast<double>(n))) % n);
      }
    for (std::size_t k = 0; k < n; ++k)
      for (const std::size_t end : {std::size_t{0}, n - 1}) look_at(k, end);
  }

  struct Place {
    std::size_t k = 0, m = 0;
    double error = 0.0;  ///< over C_km
  };
  Place worst() const {
    Place place;
    for (std::size_t k = 0; k < n_; ++k)
      if (std::abs(diagonal_[k]) > place.error) place = {k, k, std::abs(diagonal_[k])};
    for (const Sample& s : sample_)
      if (std::abs(s.rest) * s.to_own_rate > place.error) place = {s.k, s.m, std::abs(s.rest) * s.to_own_rate};
    return place;
  }

  void take(const Place& place) {
    const std::vector<double> row_k = rest_of_row(place.k);
    if (place.k == place.m) return take_one(place.k, row_k);
    take_two(place.k, place.m, row_k, rest_of_row(place.m));
  }

  std::size_t terms() const { return terms_.size(); }

  CrossApproximation result(double error, bool converged) const {
    CrossApproximation a;
    a.error = error, a.converged = converged;
    for (const Term& term : terms_) {
      auto& list = term.sign > 0.0 ? a.plus : a.minus;
      list.emplace_back(n_);
      for (std::size_t k = 0; k < n_; ++k) list.back()[k] = term.u[k] * scale_[k];
    }
    if (error == 0.0) return a;
    a.plus.emplace_back(n_);
    for (std::size_t k = 0; k < n_; ++k) a.plus.back()[k] = std::sqrt(error) * scale_[k];
    return a;
  }

 private:
  struct Term {
    std::vector<double> u;
    double sign;
  };
  struct Sample {
    std::size_t k, m;
    double rest;         ///< scaled
    double to_own_rate;  ///< sqrt(C_kk C_mm) / C_km
  };

  void look_at(std::size_t k, std::size_t m) {
    const double rate = collisions(k, m);
    if (rate > 0.0) sample_.push_back({k, m, entry(k, m), scale_[k] * scale_[m] / rate});
  }
  double collisions(std::size_t k, std::size_t m) const {
    double rate = 0.0;
    kernel_->collisions(*particles_, static_cast<int>(k), static_cast<int>(m), 1, &rate);
    return rate;
  }
  double scaled(double beta, std::size_t k, std::size_t m) const {
    const double scale = scale_[k] * scale_[m];
    return scale > 0.0 ? beta / scale : 0.0;
  }
  double entry(std::size_t k, std::size_t m) const {
    double beta = 0.0;
    kernel_->row(*particles_, static_cast<int>(k), static_cast<int>(m), 1, &beta);
    return scaled(beta, k, m);
  }

  std::vector<double> rest_of_row(std::size_t k) const {
    std::vector<double> rest(n_);
    kernel_->row(*particles_, static_cast<int>(k), 0, static_cast<int>(n_), rest.data());
    for (std::size_t m = 0; m < n_; ++m) rest[m] = scaled(rest[m], k, m);
    for (const Term& term : terms_) {
      const double by = term.sign * term.u[k];
      for (std::size_t m = 0; m < n_; ++m) rest[m] -= by * term.u[m];
    }
    return rest;
  }

  /// Takes sign u u^T out of what is left; u = by (a row_p + b row_q).
  void subtract(double sign, double by, double a, const std::vector<double>& row_p, double b,
                const std::vector<double>& row_q) {
    Term term{std::vector<double>(n_), sign};
    for (std::size_t k = 0; k < n_; ++k) term.u[k] = by * (a * row_p[k] + b * row_q[k]);
    for (std::size_t k = 0; k < n_; ++k) diagonal_[k] -= sign * term.u[k] * term.u[k];
    for (Sample& s : sample_) s.rest -= sign * term.u[s.k] * term.u[s.m];
    terms_.push_back(std::move(term));
  }

  void take_one(std::size_t p, const std::vector<double>& row) {
    const double pivot = row[p];
    if (std::abs(pivot) < kNothing) return diagonal_[p] = 0.0, void();
    subtract(pivot > 0.0 ? 1.0 : -1.0, 1.0 / std::sqrt(std::abs(pivot)), 1.0, row, 0.0, row);
  }

  /// The block of two pivots [a b; b c] diagonalised: its inverse is sum_i w_i w_i^T / lambda_i.
  void take_two(std::size_t p, std::size_t q, const std::vector<double>& row_p, const std::vector<double>& row_q) {
    const double a = row_p[p], b = row_p[q], c = row_q[q];
    const double angle = 0.5 * std::atan2(2.0 * b, a - c), cosine = std::cos(angle), sine = std::sin(angle);
    const std::array<double, 2> lambda{a * cosine * cosine + 2.0 * b * cosine * sine + c * sine * sine,
                                       a * sine * sine - 2.0 * b * cosine * sine + c * cosine * cosine};
    const double largest = std::max(std::abs(lambda[0]), std::abs(lambda[1]));
    for (std::size_t i = 0; i < 2; ++i) {
      if (std::abs(lambda[i]) < kNothing || std::abs(lambda[i]) < 1e-10 * largest) continue;
      subtract(lambda[i] > 0.0 ? 1.0 : -1.0, 1.0 / std::sqrt(std::abs(lambda[i])), i == 0 ? cosine : -sine, row_p,
               i == 0 ? sine : cosine, row_q);
    }
  }

  const PairKernel* kernel_;
  const ParticleTable* particles_;
  std::size_t n_;
  std::vector<double> scale_;     ///< sqrt(C_kk)
  std::vector<double> diagonal_;  ///< what is left of it, scaled
  std::vector<Sample> sample_;
  std::vector<Term> terms_;
};

}  // namespace

CrossApproximation approximate(const PairKernel& kernel, const ParticleTable& particles, std::size_t n_classes,
                               double tolerance, std::size_t most_terms) {
  Cross cross(kernel, particles, n_classes);
  for (std::size_t pivots = 0;; ++pivots) {
    const Cross::Place worst = cross.worst();
    if (worst.error <= tolerance) return cross.result(worst.error, true);
    if (cross.terms() >= most_terms || pivots >= most_terms) return cross.result(worst.error, false);
    cross.take(worst);
  }
}

}  // namespace granary::pbm
