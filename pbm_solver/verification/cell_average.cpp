#include "pbm_solver/verification/cell_average.hpp"

namespace granary::pbm {
namespace {

void share_one(const ClassGrid& grid, int i, int j, const Birth& birth, FieldRates rates) {
  const double mean_1 = birth.solid_1 / birth.number;
  const double mean_2 = birth.solid_2 / birth.number;
  const PivotShare rows = grid.axis(0).share(i, mean_1);
  const PivotShare columns = grid.axis(1).share(j, mean_2);
  const double per_solid = 1.0 / (mean_1 + mean_2);
  for (int a = 0; a < 2; ++a)
    for (int b = 0; b < 2; ++b) {
      const double weight = (a == 0 ? rows.to_lower : rows.to_upper) * (b == 0 ? columns.to_lower : columns.to_upper);
      if (weight == 0.0) continue;
      const std::size_t k = grid.index(rows.lower + a, columns.lower + b);
      const double solid_weight = weight * grid.solid()[k] * per_solid;
      rates.number[k] += weight * birth.number;
      rates.liquid[k] += solid_weight * birth.liquid;
      rates.gas[k] += solid_weight * birth.gas;
    }
}

}  // namespace

Birth BirthGrid::oversize() const {
  Birth sum;
  for (int i = 0; i + 1 < rows_; ++i) sum += at(i, columns_ - 1);
  for (int j = 0; j < columns_; ++j) sum += at(rows_ - 1, j);
  return sum;
}

void share_births(const ClassGrid& grid, const BirthGrid& births, FieldRates rates) {
  for (int i = 0; i < grid.axis(0).size(); ++i)
    for (int j = 0; j < grid.axis(1).size(); ++j)
      if (births.at(i, j).number > 0.0) share_one(grid, i, j, births.at(i, j), rates);
}

}  // namespace granary::pbm
