#include "pbm_solver/model/model_tables.hpp"

namespace granary::pbm {

std::array<double, 4> holdup(const ClassGrid& grid, Fields state) {
  std::array<double, 4> sum{};
  for (std::size_t k = 0; k < grid.size(); ++k) {
    sum[0] += grid.solid_1()[k] * state.number[k];
    sum[1] += grid.solid_2()[k] * state.number[k];
    sum[2] += state.liquid[k];
    sum[3] += state.gas[k];
  }
  return sum;
}

Inputs inputs_at(const PbmCase& c, double time) {
  return {c.feed && time >= c.feed->start && time < c.feed->end,
          c.spray && time >= c.spray->start && time < c.spray->end};
}

ModelTables::ModelTables(const PbmCase& c)
    : pbm_case(c),
      grid(c.grid),
      lanes(lanes_for(c.compartments.count)),
      view{grid.axis(0).size(), grid.axis(1).size(), grid.axis(0).pivots().data(), grid.axis(1).pivots().data()},
      solids(grid, c.materials, lanes) {
  if (c.aggregation) aggregation.emplace(c, grid);
  if (c.breakage) fragments.emplace(grid, c.breakage->daughters, c.breakage->table);
}

}  // namespace granary::pbm
