#include "pbm_solver/verification/exact_solutions.hpp"

#include <algorithm>
#include <array>
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

struct Node {
  double x, weight;
};

/// Gauss-Legendre on [-1, 1], 5 nodes.
constexpr std::array<Node, 5> kGauss{{{0.0, 0.5688888888888889},
                                      {-0.5384693101056831, 0.47862867049936647},
                                      {0.5384693101056831, 0.47862867049936647},
                                      {-0.906179845938664, 0.23692688505618908},
                                      {0.906179845938664, 0.23692688505618908}}};

/// Nodes for integrals over [low, high]: pieces of at most half an octave; the first of a cell from 0 starts at high /
/// 2^12.
std::vector<Node> nodes(double low, double high) {
  std::vector<Node> list;
  const auto add = [&](double from, double to) {
    for (const Node& g : kGauss)
      list.push_back({0.5 * (from + to) + 0.5 * (to - from) * g.x, 0.5 * (to - from) * g.weight});
  };
  double from = low;
  if (low == 0.0) {
    from = high / 4096.0;
    add(0.0, from);
  }
  const int pieces = std::max(1, static_cast<int>(std::ceil(2.0 * std::log2(high / from))));
  const double ratio = std::pow(high / from, 1.0 / pieces);
  for (int p = 0; p < pieces; ++p, from *= ratio) add(from, p + 1 == pieces ? high : from * ratio);
  return list;
}

std::vector<std::vector<Node>> nodes_of(const SolidAxis& axis) {
  if (axis.absent()) return {{{0.0, 1.0}}};
  std::vector<std::vector<Node>> cells;
  for (int i = 0; i < axis.size(); ++i) cells.push_back(nodes(axis.lower_edge(i), axis.lower_edge(i + 1)));
  return cells;
}

}  // namespace

double constant_kernel(double v, double t) { return 4.0 / ((2.0 + t) * (2.0 + t)) * std::exp(-2.0 * v / (2.0 + t)); }

double sum_kernel(double v, double t) {
  const double T = 1.0 - std::exp(-t), root = std::sqrt(T);
  if (T == 0.0) return std::exp(-v);
  return (1.0 - T) / (v * root) * std::exp(-(1.0 - root) * (1.0 - root) * v) * scaled_bessel_i(1.0, 2.0 * v * root);
}

double linear_breakage(double v, double t) { return (1.0 + t) * (1.0 + t) * std::exp(-v * (1.0 + t)); }

double constant_kernel_2d(double x, double y, double t) {
  const double argument = 2.0 * std::sqrt(t / (t + 2.0) * x * y);
  return 4.0 / ((t + 2.0) * (t + 2.0)) * std::exp(argument - x - y) * scaled_bessel_i(0.0, argument);
}

double sum_kernel_2d(double x, double y, double t) {
  const double T = 1.0 - std::exp(-2.0 * t), mean = 0.5 * (x + y);
  // The sum grows as exp(3 z^(1/3)) while the factor before it shrinks: a long double holds both.
  const long double z = static_cast<long double>(T * mean) * x * y;
  const double growth = 3.0 * std::cbrt(static_cast<double>(z));
  if (T * mean + x + y - growth > 700.0 || growth > 11000.0) return 0.0;  // beyond all doubles, or all long doubles
  long double term = 1.0L, sum = 1.0L;
  for (int k = 0; term > 1e-20L * sum && k < 100000; ++k) {
    term *= z / (static_cast<long double>(k + 2) * (k + 1) * (k + 1));
    sum += term;
  }
  return static_cast<double>((1.0L - T) * std::exp(-static_cast<long double>(T * mean + x + y)) * sum);
}

BirthGrid cell_content(const ClassGrid& grid, const std::function<double(double, double)>& density) {
  const auto rows = nodes_of(grid.axis(0)), columns = nodes_of(grid.axis(1));
  BirthGrid content(grid);
  for (int i = 0; i < grid.axis(0).size(); ++i)
    for (int j = 0; j < grid.axis(1).size(); ++j)
      for (const Node& x : rows[static_cast<std::size_t>(i)])
        for (const Node& y : columns[static_cast<std::size_t>(j)]) {
          const double number = x.weight * y.weight * density(x.x, y.x);
          content.at(i, j) += {number, number * x.x, number * y.x, 0.0, 0.0};
        }
  return content;
}

std::vector<double> at_pivots(const ClassGrid& grid, const BirthGrid& content) {
  std::vector<double> number(grid.size()), none(2 * grid.size());
  share_births(grid, content, {number, std::span(none).first(grid.size()), std::span(none).last(grid.size())});
  return number;
}

}  // namespace granary::pbm::exact
