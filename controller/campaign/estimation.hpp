// What of a campaign is fitted to which data: the workflow's section "estimation" as understood. Plain data, SI.
// The keys a user writes: docs/workflow_format.md#estimation. What is done with it is controller/estimation's.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/json/value.hpp"
#include "estimation/problem/parameter.hpp"
#include "estimation/problem/target.hpp"
#include "pbm_solver/case/pbm_case.hpp"

namespace granary::campaign {

struct Estimation {
  /// A setting of the workflow; what it is in every case of a PBM.
  struct Parameter {
    std::string key;   ///< "/pbm/aggregation/rate"
    std::string unit;  ///< "1/s"; "1": none
    estimation::Parameter is;
  };

  /// Stated as known: not fitted, listed in the report.
  struct Fixed {
    std::string key, unit;
    double value = 0.0;
  };

  /// One process that was measured.
  struct Experiment {
    std::string name;
    pbm::PbmCase balance;                ///< the whole process: end_time is its duration
    std::optional<pbm::DemRates> rates;  ///< of a DEM with this experiment's speed; none: the campaign's own
  };

  enum class Adopt {
    never,         ///< the estimate is reported
    end,           ///< and the balance runs once more with it
    continuously,  ///< and each PBM burst starts with the best that is known
  };

  std::vector<Parameter> parameters;
  std::vector<Fixed> fixed;
  std::vector<Experiment> experiments;
  std::vector<estimation::Target> targets;
  std::vector<std::string> sources;  ///< of each target: "data/d50.csv", or "" if it is in the workflow itself
  std::string method = "hybrid";
  std::int64_t seed = 1;
  Adopt adopt = Adopt::end;
  std::int64_t most_evaluations = 5000;  ///< for each set of rates
};

std::string_view name_of(Estimation::Adopt adopt);
/// The SI unit of a quantity's values; "1" where it has none. At the outlet some are rates.
std::string unit_of(estimation::Quantity quantity, int compartment);
/// A number in a unit as people read it: "86.1 um", "0.004", "0.012 1/s".
std::string shown(double value, const std::string& unit);

/// As understood, for campaign.json.
json::Value to_json(const Estimation& estimation);

}  // namespace granary::campaign
