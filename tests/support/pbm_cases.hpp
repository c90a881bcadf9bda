// Population balances for tests: small, quick, and with whatever mechanisms a test asks for.
#pragma once

#include <algorithm>
#include <vector>

#include "pbm_solver/case/pbm_case.hpp"

namespace granary::pbm::testing {

/// n x n classes, ratio 3, one closed compartment of 1 m^3, nothing happens.
inline PbmCase a_case(int bins = 8) {
  PbmCase c;
  c.name = "test";
  c.grid = {{bins, bins}, {1.0, 1.0}, {3.0, 3.0}};
  c.compartments.volume = {1.0};
  return c;
}

/// The campaign's kind of case: DEM kernel, Stokes efficiency, impact breakage, consolidation, feed, spray and flow
/// through a row.
inline PbmCase a_granulator(int bins = 16, int n_compartments = 4) {
  PbmCase c;
  c.name = "granulator";
  c.grid = {{bins, bins}, {5e-16, 5e-16}, {3.0, 3.0}};
  c.compartments = {n_compartments, std::vector<double>(static_cast<std::size_t>(n_compartments), 1e-3), 20.0};
  Feed feed;
  feed.porosity = 0.5;
  const double rates[] = {726657587, 286654401, 118218011, 50319795, 20954036, 7345998, 1500147, 76518, 149};
  for (int k = 0; k < std::min(9, bins); ++k) feed.classes.push_back({k, k, rates[k]});
  c.feed = feed;
  c.spray = Spray{1.458e-6, 0, 2.5, 1e300};
  DemRates dem;
  for (double d = 2e-5; d < 2e-3; d *= 1.7) dem.diameter.push_back(d);
  for (const double p : dem.diameter) {
    dem.collision_rate.emplace_back();
    for (const double q : dem.diameter) dem.collision_rate.back().push_back(2e-3 * (p + q) * (p + q) * (p + q));
    dem.impact_rate.push_back(5.0);
  }
  dem.collision_speed = {0.0, 0.8};
  dem.impact_speed = {0.5, 0.8};
  c.dem = dem;
  Aggregation aggregation;
  aggregation.kernel = Aggregation::Kernel::dem;
  aggregation.efficiency.model = Efficiency::Model::stokes;
  aggregation.efficiency.asperity = 1e-7;
  c.aggregation = aggregation;
  c.breakage = Breakage{};
  c.breakage->rate = 0.02;
  c.consolidation = Consolidation{0.02, 0.2};
  c.end_time = 25.0;
  return c;
}

}  // namespace granary::pbm::testing
