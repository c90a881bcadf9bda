#include "pbm_solver/verification/cell_content.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace granary::pbm::exact {
namespace {

struct Node {
  double x, weight;
};

/// Gauss-Legendre on [-1, 1], 5 nodes.
constexpr std::array<Node, 5> kGauss{{{0.0, 0.5688888888888889},
                                      {-0.5384693101056831, 0.47862867049936647},
                                      {0.5384693101056831, 0.47862867049936647},
                                      {-0.906179845938664, 0.23692688505618908},
                                      {0.906179845938664, 0.23692688505618908}}};

/// Nodes for integrals over [low, high]: pieces of at most half an octave; the first of a
/// cell from 0 is a sixteenth of it, as the densities are smooth there.
std::vector<Node> nodes(double low, double high) {
  std::vector<Node> list;
  const auto add = [&](double from, double to) {
    for (const Node& g : kGauss)
      list.push_back({0.5 * (from + to) + 0.5 * (to - from) * g.x, 0.5 * (to - from) * g.weight});
  };
  double from = low;
  if (low == 0.0) {
    from = high / 16.0;
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

BirthGrid cell_content(const ClassGrid& grid, const Density& density) {
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

void add_particles(const ClassGrid& grid, double x, double y, double number, BirthGrid& content) {
  content.at(grid.axis(0).cell(x), grid.axis(1).cell(y)) += {number, number * x, number * y, 0.0, 0.0};
}

void add_pure(const ClassGrid& grid, int solid, const std::function<double(double)>& density, BirthGrid& content) {
  const auto cells = nodes_of(grid.axis(solid));
  for (int i = 0; i < grid.axis(solid).size(); ++i)
    for (const Node& v : cells[static_cast<std::size_t>(i)]) {
      const double number = v.weight * density(v.x), volume = number * v.x;
      content.at(solid == 0 ? i : 0, solid == 0 ? 0 : i) +=
          {number, solid == 0 ? volume : 0.0, solid == 0 ? 0.0 : volume, 0.0, 0.0};
    }
}

std::vector<double> at_pivots(const ClassGrid& grid, const BirthGrid& content) {
  std::vector<double> number(grid.size()), none(2 * grid.size());
  share_births(grid, content, {number, std::span(none).first(grid.size()), std::span(none).last(grid.size())});
  return number;
}

}  // namespace granary::pbm::exact
