// coupling: when the two sides take turns. resources, outputs, cost_model: where it runs, what it leaves, what it would
// cost.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "common/json/reader.hpp"
#include "controller/campaign/sections.hpp"

namespace granary::campaign {
namespace {

using json::Range;

/// A word for an #SBATCH line: nothing that could end it, or be split.
bool is_word(const std::string& text) {
  const auto fine = [](unsigned char c) {
    return std::isgraph(c) != 0 && c != '"' && c != '\'' && c != '\\' && c != '#';
  };
  return !text.empty() && text.size() <= 500 && std::all_of(text.begin(), text.end(), fine);
}

std::string read_word(json::Reader& reader, const char* key) {
  std::string text = reader.text_or(key, "");
  if (!text.empty() && (!is_word(text) || text[0] == '-'))
    reader.problem(key, "it must be one word, as Slurm knows it, and not begin with '-'.");
  return text;
}

void read_options(json::Reader& reader, Resources& resources) {
  resources.options = reader.texts_or("options", {});
  for (const std::string& option : resources.options) {
    if (!option.starts_with("--") || !is_word(option))
      reader.problem("options", "\"" + option + "\" is no option in one word.", "Write it as \"--key=value\".");
    for (const char* own : {"nodes", "partition", "account", "time", "signal", "array", "chdir", "wrap", "requeue"})
      if (option == fmt::format("--{}", own) || option.starts_with(fmt::format("--{}=", own)))
        reader.problem("options", "\"" + option + "\" is set by granary itself.",
                       "The other settings of /resources say what it shall be.");
  }
}

void read_resources(json::Reader reader, Resources& resources) {
  const bool slurm = reader.choice_or("backend", "local", {"local", "slurm"}) == "slurm";
  resources.backend = slurm ? Resources::Backend::slurm : Resources::Backend::local;
  resources.nodes = static_cast<int>(reader.integer_or("nodes", resources.nodes, Range::between(1, 100000)));
  if (reader.has("cores")) resources.cores = static_cast<int>(reader.integer("cores", Range::between(1, 100000)));
  resources.partition = read_word(reader, "partition");
  resources.account = read_word(reader, "account");
  if (reader.has("walltime")) resources.walltime = reader.quantity("walltime", "s", Range::at_least(60.0));
  resources.stop_before = reader.quantity_or("stop_before", resources.stop_before, "s", Range::between(1.0, 65535.0));
  if (resources.walltime && *resources.walltime <= resources.stop_before)
    reader.problem("stop_before", "it must be less than /resources/walltime.", "A few times the longest stop.grace.");
  resources.chain = static_cast<int>(reader.integer_or("chain", resources.chain, Range::between(0, 1000)));
  resources.exclusive = reader.boolean_or("exclusive", resources.exclusive);
  read_options(reader, resources);
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
