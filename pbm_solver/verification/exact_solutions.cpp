#include "pbm_solver/verification/exact_solutions.hpp"

#include <algorithm>
#include <cmath>

#include "common/units.hpp"

namespace granary::pbm::exact {
namespace {

/// exp(-x) I_nu(x); the standard function overflows for x beyond some 700.
double scaled_bessel_i(double nu, double x) {
  if (x < 500.0) return std::exp(-x) * std::cyl_bessel_i(nu, x);
  const double m = 4.0 * nu * nu;
  return (1.0 - (m - 1.0) / (8.0 * x) + (m - 1.0) * (m - 9.0) / (128.0 * x * x)) / std::sqrt(2.0 * kPi * x);
}

/// exp(-x) (I_0(x) - J_0(x)) = exp(-x) 2 sum over odd k of (x/2)^(2k) / k!^2.
double scaled_bessel_difference(double x) {
  if (x < 1.0) {
    const double q = 0.25 * x * x;
    return std::exp(-x) * 2.0 * q * (1.0 + q * q / 36.0 * (1.0 + q * q / 400.0 * (1.0 + q * q / 1764.0)));
  }
  return scaled_bessel_i(0.0, x) - (x < 700.0 ? std::exp(-x) * std::cyl_bessel_j(0.0, x) : 0.0);
}

// The series below grow as exp(growth) while the factor before them shrinks. A long double holds both up to here;
// beyond it, and where the product is below 1e-43, the density is 0.
constexpr double kLargestGrowth = 11000.0;
constexpr double kSmallest = -100.0;
constexpr long double kEnough = 1e-20L;

/// exp(-decay) sum_k term_k from the ratio of neighbouring terms, term_0 = 1.
template <class Ratio>
double damped_series(double decay, double growth, Ratio ratio) {
  if (growth - decay < kSmallest || growth > kLargestGrowth) return 0.0;
  long double term = 1.0L, sum = 1.0L;
  for (int k = 0; term > kEnough * sum; ++k) {
    term *= ratio(k);
    sum += term;
  }
  return static_cast<double>(std::exp(-static_cast<long double>(decay)) * sum);
}

}  // namespace

double constant_kernel(double v, double t) { return 4.0 / ((2.0 + t) * (2.0 + t)) * std::exp(-2.0 * v / (2.0 + t)); }

double sum_kernel(double v, double t) {
  const double T = 1.0 - std::exp(-t), root = std::sqrt(T);
  if (T == 0.0) return std::exp(-v);
  return (1.0 - T) / (v * root) * std::exp(-(1.0 - root) * (1.0 - root) * v) * scaled_bessel_i(1.0, 2.0 * v * root);
}

double product_kernel(double v, double t) {
  const long double z = static_cast<long double>(t) * v * v * v;
  return damped_series((1.0 + t) * v, 3.0 * std::cbrt(0.25 * static_cast<double>(z)), [z](int k) {
    return z / (static_cast<long double>(k + 2) * (2.0L * k + 2.0L) * (2.0L * k + 3.0L));
  });
}

double constant_kernel_count(int k, double t) { return std::pow(0.5 * t, k - 1) / std::pow(1.0 + 0.5 * t, k + 1); }

double sum_kernel_count(int k, double t) {
  const double T = 1.0 - std::exp(-t);
  if (T == 0.0) return k == 1 ? 1.0 : 0.0;
  return (1.0 - T) * std::exp((k - 1) * std::log(k * T) - k * T - std::lgamma(k + 1.0));
}

double product_kernel_count(int k, double t) {
  if (t == 0.0) return k == 1 ? 1.0 : 0.0;
  return std::exp((k - 2) * std::log(k) + (k - 1) * std::log(t) - k * t - std::lgamma(k + 1.0));
}

double constant_kernel_2d(double x, double y, double t) {
  const double argument = 2.0 * std::sqrt(t / (t + 2.0) * x * y);
  return 4.0 / ((t + 2.0) * (t + 2.0)) * std::exp(argument - x - y) * scaled_bessel_i(0.0, argument);
}

double constant_kernel_gamma_2d(double x, double y, double mean_x, double mean_y, double t) {
  const double X = x / mean_x, Y = y / mean_y;
  if (t == 0.0) return 16.0 / (mean_x * mean_y) * X * Y * std::exp(-2.0 * (X + Y));
  const double argument = 4.0 * std::sqrt(std::sqrt(t / (t + 2.0)) * X * Y);
  return 8.0 / (mean_x * mean_y * std::sqrt(t) * std::pow(t + 2.0, 1.5)) * std::exp(argument - 2.0 * (X + Y)) *
         scaled_bessel_difference(argument);
}

double constant_kernel_mixed(double x, double y, double share_1, double t) {
  const double a = share_1, b = 1.0 - a, k = t / (t + 2.0), c = k * k * a * b;
  const double z = 2.0 * std::sqrt(c * x * y);
  const double once = a * std::sqrt(c * x / y) + b * std::sqrt(c * y / x);
  return 4.0 / ((t + 2.0) * (t + 2.0)) * std::exp(z - (1.0 - k * a) * x - (1.0 - k * b) * y) *
         (once * scaled_bessel_i(1.0, z) + 2.0 * k * a * b * scaled_bessel_i(0.0, z));
}

double constant_kernel_pure(double x, double share, double t) {
  return 4.0 / ((t + 2.0) * (t + 2.0)) * share * std::exp(-(1.0 - t / (t + 2.0) * share) * x);
}

double sum_kernel_2d(double x, double y, double t) {
  const double T = 1.0 - std::exp(-2.0 * t), mean = 0.5 * (x + y);
  const long double z = static_cast<long double>(T * mean) * x * y;
  const double growth = 3.0 * std::cbrt(static_cast<double>(z));
  return (1.0 - T) * damped_series(T * mean + x + y, growth,
                                   [z](int k) { return z / (static_cast<long double>(k + 2) * (k + 1) * (k + 1)); });
}

double product_kernel_2d(double x, double y, double t) {
  const long double v = static_cast<long double>(x) + y, X = x, Y = y;
  // Over all compositions the sums come to z^k / k!^4 with z = 8 t v^4 / 27, up to factors that do not matter here.
  const double decay = (t + 2.0) * (x + y);
  const double growth = 4.0 * std::pow(t / 3.375, 0.25) * (x + y) + 2.0;
  if (growth - decay < kSmallest || growth > kLargestGrowth) return 0.0;
  long double outer = 4.0L, sum = 0.0L;  // (t v)^k 4^(k+1) / (k + 1)!
  long double first = X;                 // x^(2k+1) / (2k+1)! y^k / k!
  for (int k = 0;; ++k) {
    long double inner = 0.0L, term = first;
    for (int j = 0; j <= k + 1; ++j) {
      inner += term;
      term *= static_cast<long double>(k + 1 - j) / (j + 1) * (2 * k + 1 - j) / X * Y / (k + j + 1);
    }
    sum += outer * inner;
    if (k > 2 && outer * inner < kEnough * sum) break;
    outer *= 4.0L * t * v / (k + 2);
    first *= X * X / ((2.0L * k + 2.0L) * (2.0L * k + 3.0L)) * Y / (k + 1);
  }
  return static_cast<double>(std::exp(-static_cast<long double>(decay)) * sum / v);
}

double linear_breakage(double v, double t) { return (1.0 + t) * (1.0 + t) * std::exp(-v * (1.0 + t)); }

double linear_breakage_fragments(double v, double t) {
  return v < 1.0 ? std::exp(-t * v) * (2.0 * t + t * t * (1.0 - v)) : 0.0;
}

double square_breakage(double v, double t) { return std::exp(-t * v * v - v) * (1.0 + 2.0 * t * (1.0 + v)); }

double balanced(double v, double s, double t) {
  const double q = std::sqrt(2.0 * s), tanh = std::tanh(0.5 * q * t);
  const double p = q * (1.0 + q * tanh) / (q + tanh);
  return p * p * std::exp(-p * v);
}

double balanced_gamma(double v, double t) {
  if (t == 0.0) return 4.0 * v * std::exp(-2.0 * v);
  const double e = std::exp(-t);
  const double root = 0.25 * std::sqrt(t * t + (10.0 - 2.0 * e) * t + 25.0 - 26.0 * e + e * e);
  const auto part = [&](double p) {
    return (7.0 + t + e + p * (2.0 - 2.0 * e)) / (9.0 + t - e + 4.0 * p) * std::exp(p * v);
  };
  return part(0.25 * (e - t - 9.0) + root) + part(0.25 * (e - t - 9.0) - root);
}

double stirred_tank(double v, double turnover) {
  const double c = std::sqrt(turnover * turnover + 2.0 * turnover), b = turnover / (c * c);
  return c * b * std::exp(-(1.0 - 2.0 * b) * v) * (scaled_bessel_i(0.0, b * v) - scaled_bessel_i(1.0, b * v));
}

double tank_filling(int tank, double turnover, double t) {
  double term = std::exp(-turnover * t), missing = term;
  for (int k = 1; k <= tank; ++k) missing += term *= turnover * t / k;
  return 1.0 - missing;
}

}  // namespace granary::pbm::exact
