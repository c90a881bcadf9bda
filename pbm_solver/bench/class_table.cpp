#include "pbm_solver/bench/class_table.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "common/assert.hpp"
#include "common/math/size_distribution.hpp"

namespace granary::pbm::bench {

void set_class_table(PbmCase& c, int n_classes, double rate) {
  const ClassGrid grid(c.grid);
  // A little beyond both ends, so that no class lies on a border, where round-off would choose its side.
  const double least = std::log(*std::min_element(grid.solid().begin(), grid.solid().end())) - 0.11;
  const double most = std::log(*std::max_element(grid.solid().begin(), grid.solid().end())) + 0.23;
  DemRates dem;
  for (int a = 0; a < n_classes; ++a)
    dem.diameter.push_back(sphere_diameter(std::exp(least + (most - least) * (a + 0.5) / n_classes)));
  const auto n = static_cast<std::size_t>(n_classes);
  dem.collision_rate.assign(n, std::vector<double>(n));
  std::mt19937 random(20);
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      const double both = dem.diameter[a] + dem.diameter[b];
      const double factor = 0.5 + static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
      dem.collision_rate[a][b] = dem.collision_rate[b][a] = rate * factor * both * both * both;
    }
  c.dem = dem;
  c.aggregation = Aggregation{};
  c.aggregation->kernel = Aggregation::Kernel::dem;
  c.aggregation->lookup = Aggregation::Lookup::group;
}

ClassTable class_table_of(const PbmCase& c, const ClassGrid& grid) {
  GRANARY_ASSERT(c.aggregation && c.aggregation->efficiency.model == Efficiency::Model::constant,
                 "no such kernel here");
  const Aggregation& aggregation = *c.aggregation;
  const bool constant = aggregation.kernel == Aggregation::Kernel::constant;
  GRANARY_ASSERT(constant || aggregation.kernel == Aggregation::Kernel::dem, "no such kernel here");
  ClassTable table;
  table.class_of.assign(grid.size(), 0);
  table.rate = {1.0};
  for (std::size_t x = 0; x < c.compartments.volume.size(); ++x) {
    const bool factor = !constant && !c.dem->compartment_factor.empty();
    table.scale.push_back(aggregation.rate * aggregation.efficiency.value *
                          (factor ? c.dem->compartment_factor[x] : 1.0) / c.compartments.volume[x]);
  }
  if (constant) return table;

  table.size = c.dem->diameter.size();
  table.rate.clear();
  for (const std::vector<double>& row : c.dem->collision_rate)
    table.rate.insert(table.rate.end(), row.begin(), row.end());
  std::vector<double> borders;
  for (std::size_t a = 0; a + 1 < table.size; ++a)
    borders.push_back(std::sqrt(c.dem->diameter[a] * c.dem->diameter[a + 1]));
  for (std::size_t k = 0; k < grid.size(); ++k)
    table.class_of[k] = static_cast<std::size_t>(
        std::upper_bound(borders.begin(), borders.end(), sphere_diameter(grid.solid()[k])) - borders.begin());
  return table;
}

}  // namespace granary::pbm::bench
