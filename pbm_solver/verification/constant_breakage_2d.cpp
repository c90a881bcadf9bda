// The exact solution for breakage of two solids at a constant rate: its series, summed cell by cell.
#include <cmath>
#include <vector>

#include "pbm_solver/verification/exact_solutions.hpp"

namespace granary::pbm::exact {
namespace {

constexpr double kLastExponent = 40.0;  // exp(-40) is below round-off
constexpr double kPiece = 0.25;         // the integrand is smooth: 1e-12 with 5 nodes on pieces of this length

/// g_k(x), k = 1 .. cuts, by Gauss-Legendre in s; [0] is exp(-x).
std::vector<double> shapes(double x, int cuts) {
  static constexpr double kNode[5] = {0.0, -0.5384693101056831, 0.5384693101056831, -0.906179845938664,
                                      0.906179845938664};
  static constexpr double kWeight[5] = {0.5688888888888889, 0.47862867049936647, 0.47862867049936647,
                                        0.23692688505618908, 0.23692688505618908};
  std::vector<double> g(static_cast<std::size_t>(cuts) + 1);
  g[0] = std::exp(-x);
  const double last = std::log(kLastExponent / x);
  for (double from = 0.0; from < last; from += kPiece)
    for (int n = 0; n < 5; ++n) {
      const double s = from + 0.5 * kPiece * (1.0 + kNode[n]);
      double term = 0.5 * kPiece * kWeight[n] * std::exp(-x * std::exp(s));  // times s^(k-1) / (k-1)!
      for (int k = 1; k <= cuts; ++k) {
        g[static_cast<std::size_t>(k)] += term;
        term *= s / k;
      }
    }
  return g;
}

/// Number and volume of each g_k below v, from that of g_(k-1): integrate by parts, x g_k' = -g_(k-1).
struct Below {
  std::vector<double> number, volume;
};
Below below(double v, int cuts) {
  const std::vector<double> g = shapes(v, cuts);
  Below b{{-std::expm1(-v)}, {-std::expm1(-v) - v * std::exp(-v)}};
  for (std::size_t k = 1; k < g.size(); ++k) {
    b.number.push_back(v * g[k] + b.number[k - 1]);
    b.volume.push_back(0.5 * (v * v * g[k] + b.volume[k - 1]));
  }
  return b;
}

/// What each g_k holds in the cells of one solid, shape (n) each.
struct AxisContent {
  std::vector<double> number, volume;
};

std::vector<AxisContent> contents(const SolidAxis& axis, int cuts) {
  std::vector<AxisContent> list(static_cast<std::size_t>(cuts) + 1);
  Below last{std::vector<double>(list.size()), std::vector<double>(list.size())};
  for (int i = 0; i < axis.size(); ++i) {
    Below next = below(axis.lower_edge(i + 1), cuts);
    for (std::size_t k = 0; k < list.size(); ++k) {
      list[k].number.push_back(next.number[k] - last.number[k]);
      list[k].volume.push_back(next.volume[k] - last.volume[k]);
    }
    last = std::move(next);
  }
  return list;
}

void add_product(double weight, const AxisContent& x, const AxisContent& y, BirthGrid& content) {
  for (std::size_t i = 0; i < x.number.size(); ++i)
    for (std::size_t j = 0; j < y.number.size(); ++j)
      content.at(static_cast<int>(i), static_cast<int>(j)) +=
          {weight * x.number[i] * y.number[j], weight * x.volume[i] * y.number[j], weight * x.number[i] * y.volume[j],
           0.0, 0.0};
}

}  // namespace

BirthGrid constant_breakage_2d(const ClassGrid& grid, double t) {
  const int cuts = 20 + static_cast<int>(10.0 * t);  // the weights are Poisson's with mean 2 t
  const auto rows = contents(grid.axis(0), cuts), columns = contents(grid.axis(1), cuts);
  BirthGrid content(grid);
  double weight = std::exp(-t);
  for (int k = 0; k <= cuts; ++k) {
    const auto at = static_cast<std::size_t>(k);
    add_product(weight, rows[at], columns[at], content);
    weight *= 2.0 * t / (k + 1);
  }
  return content;
}

}  // namespace granary::pbm::exact
