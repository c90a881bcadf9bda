#include "pbm_solver/verification/density_problem.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace granary::pbm {
namespace {

std::vector<double> start_of(const DensityProblem& problem, const ClassGrid& grid) {
  const BirthGrid content = problem.content(grid, 0.0);
  if (!problem.number_start) return exact::at_pivots(grid, content);
  std::vector<double> number;
  for (int i = 0; i < grid.axis(0).size(); ++i)
    for (int j = 0; j < grid.axis(1).size(); ++j) number.push_back(content.at(i, j).number);
  return number;
}

PbmCase case_of(const DensityProblem& problem, int bins) {
  PbmCase c;
  c.name = problem.name;
  c.grid = problem.grid(bins);
  c.compartments.volume = {1.0};
  c.aggregation = problem.aggregation;
  c.breakage = problem.breakage;
  c.end_time = c.output_every = problem.end;
  const ClassGrid grid(c.grid);
  const std::vector<double> number = start_of(problem, grid);
  if (problem.turnover) {
    c.compartments.residence_time = 1.0 / *problem.turnover;
    c.feed.emplace();
  }
  for (int i = 0; i < grid.axis(0).size(); ++i)
    for (int j = 0; j < grid.axis(1).size(); ++j) {
      const double here = number[grid.index(i, j)];
      if (!(here > 0.0)) continue;
      if (problem.turnover) c.feed->classes.push_back({i, j, *problem.turnover * here});
      if (!problem.turnover) c.initial.push_back({0, i, j, here, 0.0, 0.0});
    }
  return c;
}

/// Index of the cell that cell i is counted in.
int merged(const SolidAxis& axis, int i, double below) {
  return !axis.absent() && axis.lower_edge(i + 1) <= below ? 0 : i;
}

void compare_cells(const DensityProblem& problem, const ClassGrid& grid, const Snapshot& end, Comparison& result) {
  const BirthGrid exact = problem.content(grid, problem.end);
  BirthGrid off(grid);  // solver minus exact; the volume of both solids in solid_1
  double all_number = 0.0, all_volume = 0.0;
  for (int i = 0; i < grid.axis(0).size(); ++i)
    for (int j = 0; j < grid.axis(1).size(); ++j) {
      const std::size_t k = grid.index(i, j);
      const Birth& cell = exact.at(i, j);
      const double volume = cell.solid_1 + cell.solid_2;
      off.at(merged(grid.axis(0), i, problem.merged_below), merged(grid.axis(1), j, problem.merged_below)) +=
          {end.number[k] - cell.number, end.number[k] * grid.solid()[k] - volume, 0.0, 0.0, 0.0};
      all_number += cell.number, all_volume += volume;
    }
  double off_number = 0.0, off_volume = 0.0;
  for (int i = 0; i < grid.axis(0).size(); ++i)
    for (int j = 0; j < grid.axis(1).size(); ++j)
      off_number += std::abs(off.at(i, j).number), off_volume += std::abs(off.at(i, j).solid_1);
  result.l1_number = off_number / all_number;
  result.l1_volume = off_volume / all_volume;
}

double moment_of(const ClassGrid& grid, const std::vector<double>& number, const Moment& m) {
  double sum = 0.0;
  for (std::size_t k = 0; k < grid.size(); ++k)
    sum += number[k] * std::pow(grid.solid_1()[k], m.p) * std::pow(grid.solid_2()[k], m.q);
  return sum;
}

Comparison compare(const DensityProblem& problem, const ClassGrid& grid, const Snapshot& end) {
  Comparison result;
  if (!problem.moments_only) compare_cells(problem, grid, end, result);
  for (const Moment& m : problem.moments) {
    const double scale = problem.number_start ? moment_of(grid, start_of(problem, grid), m) / m.start : 1.0;
    result.moments.emplace_back(fmt::format("M{}{}", m.p, m.q),
                                moment_of(grid, end.number, m) / (scale * m.exact) - 1.0);
  }
  return result;
}

}  // namespace

std::function<Grid(int)> even_edges(double smallest, double largest, bool two_solids) {
  return [=](int bins) {
    const double ratio = std::pow(largest / smallest, 1.0 / bins);
    const double first = 0.5 * (1.0 + ratio) * smallest;
    return Grid{{bins, two_solids ? bins : 1}, {first, two_solids ? first : 0.0}, {ratio, two_solids ? ratio : 2.0}};
  };
}

VerificationCase make_case(DensityProblem problem, std::string reason, std::vector<Bound> grids, NamedErrors bounds) {
  VerificationCase made{problem.name,
                        problem.group,
                        problem.text,
                        std::move(reason),
                        problem.moments_only ? "M20" : "L1",
                        std::move(bounds),
                        std::move(grids),
                        {},
                        {}};
  made.pbm_case = [problem](int bins) { return case_of(problem, bins); };
  made.compare = [problem](const PbmCase&, const ClassGrid& grid, const Snapshot& end) {
    return compare(problem, grid, end);
  };
  return made;
}

}  // namespace granary::pbm
