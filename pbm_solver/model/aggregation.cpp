#include "pbm_solver/model/aggregation.hpp"

#include <algorithm>
#include <cmath>

namespace granary::pbm {
namespace {

/// First active class of a part: class p has p + 1 pairs, so equal work lies between square roots.
std::size_t part_begin(int part, std::size_t n_active) {
  return static_cast<std::size_t>(
      std::lround(static_cast<double>(n_active) * std::sqrt(double(part) / Aggregation2d::kParts)));
}

}  // namespace

Aggregation2d::Aggregation2d(const ClassGrid& grid) : grid_(&grid), parts_(kParts, Part{BirthGrid(grid), {}, {}}) {}

void Aggregation2d::run_part(int part, const AggregationKernel& kernel, const ActiveClasses& classes) {
  Part& sums = parts_[static_cast<std::size_t>(part)];
  sums.births.clear();
  sums.death.assign(classes.size(), 0.0);
  sums.beta.resize(classes.size());
  for (std::size_t p = part_begin(part, classes.size()); p < part_begin(part + 1, classes.size()); ++p) {
    kernel.row(classes, p, std::span(sums.beta).first(p + 1));
    add_pairs_of(p, classes, sums);
  }
}

/// Class p with every active class up to itself, row by row of the grid: one destination row and one sum of s1 a row.
void Aggregation2d::add_pairs_of(std::size_t p, const ActiveClasses& c, Part& sums) const {
  const int* rows = grid_->axis(0).sum_cells(c.i[p]);
  const int* columns = grid_->axis(1).sum_cells(c.j[p]);
  const double number = c.number[p], liquid = c.liquid[p], gas = c.gas[p], s2 = c.solid_2[p];
  const double* beta = sums.beta.data();
  double* deaths = sums.death.data();
  double death = 0.0;
  for (int row = 0; row <= c.i[p]; ++row) {
    Birth* into = sums.births.row(rows[row]);
    const double s1 = c.solid_1[p] + grid_->axis(0).pivot(row);
    const std::size_t end = std::min(c.row_begin[static_cast<std::size_t>(row) + 1], p);
    for (std::size_t q = c.row_begin[static_cast<std::size_t>(row)]; q < end; ++q) {
      const double hits = beta[q] * number;            // per particle of q
      const double hits_back = beta[q] * c.number[q];  // per particle of p
      const double born = hits * c.number[q];
      Birth& cell = into[columns[c.j[q]]];
      cell.number += born;
      cell.solid_1 += born * s1;
      cell.solid_2 += born * (s2 + c.solid_2[q]);
      cell.liquid += hits_back * liquid + hits * c.liquid[q];
      cell.gas += hits_back * gas + hits * c.gas[q];
      deaths[q] += hits;
      death += hits_back;
    }
  }
  const double self = beta[p] * number;
  Birth& cell = sums.births.at(rows[c.i[p]], columns[c.j[p]]);
  const double born = 0.5 * self * number;
  cell += {born, born * 2.0 * c.solid_1[p], born * 2.0 * s2, self * liquid, self * gas};
  deaths[p] += death + self;
}

void Aggregation2d::collect(const ActiveClasses& classes, BirthGrid& births, std::vector<double>& death) const {
  for (const Part& part : parts_) {
    births.add(part.births);
    for (std::size_t p = 0; p < classes.size(); ++p) death[p] += part.death[p];
  }
}

}  // namespace granary::pbm
