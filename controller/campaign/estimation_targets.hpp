// The targets of a section "estimation": written in the workflow, or in files of data. Private to controller/campaign.
#pragma once

#include "common/json/reader.hpp"
#include "controller/campaign/campaign.hpp"

namespace granary::campaign {

/// Reads the member "targets" into `estimation`, whose experiments are known. Every problem of every target is filed.
void read_targets(json::Reader& estimation_section, const Campaign& campaign, Estimation& estimation);

}  // namespace granary::campaign
