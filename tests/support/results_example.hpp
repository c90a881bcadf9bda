// Made-up campaign results of a believable shape and size, for tests of results.h5 and of the report.
// Smooth curves, no physics: nothing here is a result of ours.
#pragma once

#include "common/results/campaign_results.hpp"

namespace granary::test {

/// A two-way coupled campaign: `n_rounds` rounds of one DEM and one PBM burst and a last DEM burst, on two cores.
CampaignResults example_results(int n_compartments = 4, int n_rounds = 3);

/// Every letter of the schema has another size, and every text a character that is awkward somewhere.
CampaignResults awkward_results();

}  // namespace granary::test
