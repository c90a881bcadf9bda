// coupling: when the two sides take turns. resources, outputs, cost_model: where it runs, what it leaves, what it would
// cost.
#include "common/json/reader.hpp"
#include "controller/campaign/sections.hpp"

namespace granary::campaign {
namespace {

using json::Range;

void read_resources(json::Reader reader, Resources& resources) {
  reader.choice_or("backend", "local", {"local"});
  resources.nodes = static_cast<int>(reader.integer_or("nodes", resources.nodes, Range::between(1, 100000)));
  if (reader.has("cores")) resources.cores = static_cast<int>(reader.integer("cores", Range::between(1, 100000)));
  reader.done();
}

void read_cost_model(json::Reader reader, CostModel& cost) {
  const auto seconds = [&](const char* key, double& value) {
    value = reader.quantity_or(key, value, "s", Range::not_negative());
  };
  seconds("dem_per_particle_step", cost.dem_per_particle_step);
  seconds("dem_per_step", cost.dem_per_step);
  seconds("pbm_per_pair", cost.pbm_per_pair);
  cost.pbm_rates_per_second =
      reader.quantity_or("pbm_rates_per_second", cost.pbm_rates_per_second, "1/s", Range::positive());
  cost.parallel_loss = reader.number_or("parallel_loss", cost.parallel_loss, {0.0, 1.0, true, false});
  seconds("dem_start", cost.dem_start);
  seconds("pbm_start", cost.pbm_start);
  seconds("exchange", cost.exchange);
  cost.dem_drift_after = reader.quantity_or("dem_drift_after", cost.dem_drift_after, "s", Range::positive());
  cost.pbm_drift_after = reader.quantity_or("pbm_drift_after", cost.pbm_drift_after, "s", Range::positive());
  cost.rounds_until_steady =
      static_cast<int>(reader.integer_or("rounds_until_steady", cost.rounds_until_steady, Range::between(1, 10000)));
  reader.done();
}

}  // namespace

void read_coupling(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  using Mode = CouplingSettings::Mode;
  json::Reader reader = section_or_empty(root, "coupling", problems);
  CouplingSettings& coupling = campaign.coupling;
  const std::string mode = reader.choice_or("mode", "two-way", {"two-way", "one-way", "pbm-only"});
  coupling.mode = mode == "two-way" ? Mode::two_way : mode == "one-way" ? Mode::one_way : Mode::pbm_only;
  coupling.threshold = reader.number_or("threshold", coupling.threshold, {0.0, 10.0, false, true});
  coupling.steady_window = reader.quantity_or("steady_window", coupling.steady_window, "s", Range::positive());
  coupling.steady_tolerance = reader.number_or("steady_tolerance", coupling.steady_tolerance, {0.0, 10.0, false, true});
  coupling.significance = reader.number_or("significance", coupling.significance, Range::not_negative());
  coupling.grace = reader.quantity_or("grace", coupling.grace, "s", Range::not_negative());
  coupling.least_rounds =
      static_cast<int>(reader.integer_or("least_rounds", coupling.least_rounds, Range::between(1, 100000)));
  coupling.most_rounds =
      static_cast<int>(reader.integer_or("most_rounds", coupling.most_rounds, Range::between(1, 100000)));
  reader.done();
}

void read_running(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  read_resources(section_or_empty(root, "resources", problems), campaign.resources);
  json::Reader outputs = section_or_empty(root, "outputs", problems);
  campaign.outputs.report = outputs.boolean_or("report", campaign.outputs.report);
  outputs.done();
  read_cost_model(section_or_empty(root, "cost_model", problems), campaign.cost_model);
}

}  // namespace granary::campaign
