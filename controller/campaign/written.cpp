// campaign.json: the workflow as written and as understood. A resume reads the former and holds the result against the
// latter.
#include <fmt/format.h>

#include <algorithm>

#include "common/json/io.hpp"
#include "common/version.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/campaign/reread.hpp"
#include "pilot/task/spec_json.hpp"

namespace granary::campaign {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWrittenFormat = "granary-campaign-1";

template <class T>
json::Value or_null(const std::optional<T>& value) {
  return value ? json::Value(*value) : json::Value();
}

json::Value coupling_json(const CouplingSettings& coupling) {
  using Mode = CouplingSettings::Mode;
  const char* mode = coupling.mode == Mode::two_way   ? "two-way"
                     : coupling.mode == Mode::one_way ? "one-way"
                                                      : "pbm-only";
  return json::Value::object({{"mode", mode},
                              {"threshold", coupling.threshold},
                              {"steady_window_s", coupling.steady_window},
                              {"steady_tolerance", coupling.steady_tolerance},
                              {"significance", coupling.significance},
                              {"grace_s", coupling.grace},
                              {"least_rounds", coupling.least_rounds},
                              {"most_rounds", coupling.most_rounds}});
}

json::Value coarse_graining_law_json(const std::optional<DemSettings::CoarseGrainingLaw>& law) {
  if (!law) return {};
  return json::Value::object({{"at", law->at},
                              {"collision_rate", law->collision_rate},
                              {"collision_speed", law->collision_speed},
                              {"impact_rate", law->impact_rate},
                              {"impact_speed", law->impact_speed}});
}

json::Value dem_json(const DemSettings& dem) {
  const bool orthokinetic = dem.carry_back == DemSettings::CarryBack::orthokinetic;
  return json::Value::object({{"particles", static_cast<std::int64_t>(dem.particles)},
                              {"coarse_graining", or_null(dem.coarse_graining)},
                              {"carry_back", orthokinetic ? "orthokinetic" : "equal_speed"},
                              {"coarse_graining_law", coarse_graining_law_json(dem.coarse_graining_law)},
                              {"size_classes", dem.size_classes},
                              {"fine_cut", dem.fine_cut},
                              {"largest_diameter_m", or_null(dem.largest_diameter)},
                              {"density_kg_m3", or_null(dem.density)},
                              {"time_step_s", or_null(dem.time_step)},
                              {"tally_every", or_null(dem.tally_every)},
                              {"soft_overlap", or_null(dem.soft_overlap)},
                              {"longest_burst_s", dem.longest_burst}});
}

json::Value cost_json(const CostModel& cost) {
  return json::Value::object({{"dem_per_particle_step_s", cost.dem_per_particle_step},
                              {"dem_per_step_s", cost.dem_per_step},
                              {"pbm_per_pair_s", cost.pbm_per_pair},
                              {"pbm_rates_per_second_1_s", cost.pbm_rates_per_second},
                              {"parallel_loss", cost.parallel_loss},
                              {"dem_start_s", cost.dem_start},
                              {"pbm_start_s", cost.pbm_start},
                              {"exchange_s", cost.exchange},
                              {"dem_drift_after_s", cost.dem_drift_after},
                              {"pbm_drift_after_s", cost.pbm_drift_after},
                              {"rounds_until_steady", cost.rounds_until_steady}});
}

void add_coupled(const Campaign& campaign, json::Value& understood) {
  understood.set("solids", json::Value::array().push(campaign.solids[0]).push(campaign.solids[1]));
  understood.set("feed_rate_kg_s", campaign.feed_rate);
  understood.set("duration_s", campaign.duration);
  understood.set("compartment_edges_m", campaign.compartment_edges);
  understood.set("seeds", json::Value::object({{"dem", static_cast<std::int64_t>(campaign.dem_case.seed)}}));
  understood.set("coupling", coupling_json(campaign.coupling));
  understood.set("dem", dem_json(campaign.dem));
  understood.set("pbm", json::Value::object({{"longest_burst_s", campaign.pbm.longest_burst},
                                             {"ranks", campaign.pbm.ranks},
                                             {"threads", campaign.pbm.threads}}));
  understood.set("dem_case", dem::to_json(campaign.dem_case));
  understood.set("pbm_case", pbm::to_json(campaign.pbm_case));
  understood.set("cost_model", cost_json(campaign.cost_model));
  if (campaign.estimation) understood.set("estimation", to_json(*campaign.estimation));
}

json::Value sweep_json(const Sweep& sweep) {
  const bool dem = sweep.solver == Sweep::Solver::dem;
  json::Value settings = json::Value::array(), cases = json::Value::array();
  for (const Sweep::Setting& setting : sweep.settings)
    settings.push(json::Value::object({{"setting", setting.pointer}, {"name", setting.name}}));
  for (const SweepCase& one : sweep.cases)
    cases.push(json::Value::object({{"name", one.name},
                                    {"values", json::Value(json::Array(one.values))},
                                    {"duration_s", one.understood->duration},
                                    {dem ? "dem_case" : "pbm_case", dem ? dem::to_json(one.understood->dem_case)
                                                                        : pbm::to_json(one.understood->pbm_case)}}));
  return json::Value::object(
      {{"solver", dem ? "dem" : "pbm"}, {"settings", std::move(settings)}, {"cases", std::move(cases)}});
}

const char* name_of(Kind kind) { return kind == Kind::coupled ? "coupled" : kind == Kind::tasks ? "tasks" : "sweep"; }

json::Value resources_json(const Resources& resources) {
  return json::Value::object({{"backend", resources.backend == Resources::Backend::slurm ? "slurm" : "local"},
                              {"nodes", resources.nodes},
                              {"cores", or_null(resources.cores)},
                              {"partition", resources.partition},
                              {"account", resources.account},
                              {"walltime_s", or_null(resources.walltime)},
                              {"stop_before_s", resources.stop_before},
                              {"chain", resources.chain},
                              {"exclusive", resources.exclusive},
                              {"options", resources.options}});
}

json::Value as_understood(const Campaign& campaign) {
  json::Value understood = json::Value::object(
      {{"kind", name_of(campaign.kind)}, {"name", campaign.name}, {"description", campaign.description}});
  if (campaign.kind == Kind::coupled) {
    add_coupled(campaign, understood);
  } else if (campaign.kind == Kind::sweep) {
    understood.set("sweep", sweep_json(campaign.sweep));
  } else {
    json::Value tasks = json::Value::array();
    for (const pilot::TaskSpec& task : campaign.tasks) tasks.push(pilot::to_json(task));
    understood.set("tasks", std::move(tasks));
  }
  understood.set("resources", resources_json(campaign.resources));
  understood.set("outputs", json::Value::object({{"report", campaign.outputs.report}}));
  return understood;
}

/// Where two documents differ first; "" if nowhere.
std::string first_difference(const json::Value& a, const json::Value& b, const std::string& at) {
  if (a.is_object() && b.is_object()) {
    for (const auto& [name, value] : a.members())
      if (const auto place = first_difference(value, b[name], at + "/" + name); !place.empty()) return place;
    for (const auto& [name, value] : b.members())
      if (a.find(name) == nullptr) return at + "/" + name;
    return "";
  }
  return json::dump(a) == json::dump(b) ? "" : at;
}

}  // namespace

json::Value to_json(const Campaign& campaign) {
  return json::Value::object({{"format", kWrittenFormat},
                              {"version", version()},
                              {"revision", revision()},
                              {"file", campaign.file.string()},
                              {"folder", campaign.folder.string()},
                              {"workflow", campaign.document},
                              {"understood", as_understood(campaign)}});
}

Result<Campaign> read_written_campaign(const fs::path& file) {
  GRANARY_TRY(const json::Value written, json::read_file(file));
  if (written.text_or("format", "") != kWrittenFormat)
    return Error{file.string() + ": this is not a campaign.json of this version of Granary (its \"format\" is not \"" +
                 kWrittenFormat + "\")."};
  GRANARY_TRY(Campaign campaign, reread_campaign(written["workflow"], file, written.text_or("folder", "")));
  campaign.file = written.text_or("file", "");
  if (const auto place = first_difference(as_understood(campaign), written["understood"], ""); !place.empty()) {
    return Error{
        fmt::format("{}: {} would be understood otherwise than when the campaign began (by Granary {}, {}). "
                    "Resume it with that version, or start a new campaign.",
                    file.string(), place, written.text_or("version", "?"), written.text_or("revision", "?"))};
  }
  return campaign;
}

}  // namespace granary::campaign
