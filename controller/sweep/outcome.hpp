// What a case left in its folder, as figures and curves: of a PBM from progress.jsonl, of a DEM from fragments.jsonl,
// breaks.jsonl and tallies.jsonl. A case in the middle has those it has so far.
#pragma once

#include <filesystem>
#include <vector>

#include "controller/campaign/campaign.hpp"
#include "controller/sweep/results.hpp"
#include "pilot/pilot.hpp"

namespace granary::sweep {

/// Curves of every number in lines that have a time_s, also of those in lists ("d50_m[2]"; plain where the list has one
/// item) and in objects ("outlet.d50_m"). Lists of lists are left out.
std::vector<Curve> curves_of(const std::vector<json::Value>& lines);

/// Broken bonds so far, by cause, at the times of the samples: "broken_by_chopper", "broken_by_impeller", ...
std::vector<Curve> breaks_by_cause(const std::vector<json::Value>& breaks, const std::vector<double>& time);

/// All that is known of the sweep: settings from the campaign, states and costs from the pilot, the rest from `dir`.
/// Errors: a file that is there and cannot be read.
Result<SweepResults> collect(const campaign::Campaign& campaign, const std::filesystem::path& dir,
                             const pilot::Pilot& pilot);

}  // namespace granary::sweep
