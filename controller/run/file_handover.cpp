#include "controller/run/file_handover.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "controller/coupling/exchange_files.hpp"
#include "dem_templates/geometry/machine.hpp"
#include "dem_templates/render/automatic.hpp"
#include "dem_templates/render/deck.hpp"

namespace granary::run {
namespace fs = std::filesystem;
using coupling::BurstId;
using coupling::Kind;

namespace {

// Beside the burst's own files, what the next burst of the other kind must know of it.
constexpr const char* kSampled = "sampled.json";    // DEM: how its particles stand for the PBM's
constexpr const char* kHandover = "handover.json";  // PBM: the output time at which the DEM takes over

coupling::ScalingLaw law_of(campaign::DemSettings::CarryBack carry_back) {
  return carry_back == campaign::DemSettings::CarryBack::orthokinetic ? coupling::ScalingLaw::orthokinetic
                                                                      : coupling::ScalingLaw::equal_speed;
}

/// A further attempt starts in a clean folder; what the earlier one wrote is kept beside it.
Status set_earlier_attempt_aside(const fs::path& folder, int attempt) {
  const fs::path aside = fmt::format("{}.attempt{}", folder.string(), attempt - 1);
  std::error_code code;
  if (attempt < 2 || fs::exists(aside) || !fs::exists(folder)) return {};
  fs::rename(folder, aside, code);
  if (code)
    return Error{fmt::format("{}: cannot be set aside: {}.", folder.string(), code.message()), Exit::task_failed};
  return {};
}

/// The last complete line of a file of lines; null if there is none.
json::Value last_line(const fs::path& file) {
  const auto lines = json::LineReader(file).next();
  return lines && !lines->empty() ? lines->back() : json::Value();
}

}  // namespace

FileHandover::FileHandover(const campaign::Campaign& campaign, fs::path dir, fs::path programs)
    : campaign_(&campaign), dir_(std::move(dir)), programs_(std::move(programs)) {}

fs::path FileHandover::folder(const BurstId& burst) const { return dir_ / "bursts" / burst.folder(); }

Result<BurstTasks> FileHandover::prepare(const coupling::StartBurst& start) {
  GRANARY_CHECK(set_earlier_attempt_aside(folder(start.burst), start.attempt));
  GRANARY_CHECK(make_folders(folder(start.burst)));
  GRANARY_TRY(pilot::TaskSpec program, start.burst.kind == Kind::dem ? prepare_dem(start) : prepare_pbm(start));
  program.name = program_name(start.burst, start.attempt);
  program.dir = fs::path("bursts") / start.burst.folder();
  program.priority = 10;
  program.stop.grace = 60.0;
  BurstTasks tasks{std::move(program), std::nullopt};
  if (start.monitored) {
    tasks.monitor = monitor_task(start.burst, start.attempt);
    if (!start.watch_drift) tasks.monitor->command.push_back("--no-drift");
  }
  return tasks;
}

pilot::TaskSpec FileHandover::late_monitor(const BurstId& burst, int attempt) {
  pilot::TaskSpec task = monitor_task(burst, attempt);
  task.name += "-late";
  task.command.push_back("--finished");
  return task;
}

Result<coupling::HoldUp> FileHandover::hold_up_for(const coupling::StartBurst& start) const {
  if (!start.takes_from) return coupling::starting_hold_up(campaign_->pbm_case);
  const fs::path from = folder(*start.takes_from);
  GRANARY_TRY(const json::Value handover, json::read_file(from / kHandover));
  return coupling::read_hold_up(from / "out.h5", handover["time_s"].as_number());
}

Result<pilot::TaskSpec> FileHandover::prepare_dem(const coupling::StartBurst& start) const {
  GRANARY_TRY(const coupling::HoldUp hold_up, hold_up_for(start));
  coupling::PopulationSettings settings;
  settings.budget = campaign_->dem.particles;
  settings.size_classes = campaign_->dem.size_classes;
  settings.fine_cut = campaign_->dem.fine_cut;
  settings.largest_diameter =
      campaign_->dem.largest_diameter.value_or(dem::largest_particle(campaign_->dem_case.machine));
  settings.compartment_edge = campaign_->compartment_edges;
  settings.solid_density = campaign_->pbm_case.materials.solid_density;
  settings.liquid_density = campaign_->pbm_case.materials.liquid_density;
  if (start.restart) {
    GRANARY_TRY(const json::Value earlier, json::read_file(folder(*start.restart) / kSampled));
    settings.previous_coarse_graining = earlier.number_or("coarse_graining", 0.0);
  } else if (campaign_->dem.coarse_graining) {
    settings.previous_coarse_graining = *campaign_->dem.coarse_graining;
  }
  GRANARY_TRY(const coupling::SampledPopulation sampled, coupling::sample_population(hold_up, settings));

  dem::DemCase burst = campaign_->dem_case;
  burst.name = start.burst.folder();
  burst.population = sampled.compartments;
  burst.density = campaign_->dem.density.value_or(sampled.density);
  burst.coarse_graining = sampled.coarse_graining;
  burst.tally.class_edges = sampled.class_edge;
  burst.duration = start.longest;
  if (start.restart) {
    GRANARY_TRY(burst.impact_speed, coupling::fastest_contacts(folder(*start.restart) / "tallies.jsonl"));
  }
  if (campaign_->dem.soft_overlap)
    burst.contact.young_modulus = dem::automatic_young_modulus(burst, *campaign_->dem.soft_overlap);
  if (!campaign_->dem.time_step) burst.time_step = dem::automatic_time_step(burst);
  if (!campaign_->dem.tally_every) burst.tally.every = dem::automatic_tally_every(burst);
  burst.seed = campaign_->dem_case.seed + 7919L * start.burst.round + start.attempt - 1;
  if (start.restart) burst.restart = fs::path("..") / start.restart->folder() / "restart.liggghts";
  GRANARY_CHECK(dem::write_burst(burst, folder(start.burst)));
  GRANARY_CHECK(json::write_file(folder(start.burst) / kSampled, coupling::to_json(sampled)));

  pilot::TaskSpec task;
  task.command = {
      (programs_ / "granary-dem").string(), "-in", "in.liggghts", "-log", "log.liggghts", "-screen", "none"};
  task.ranks = burst.ranks;
  if (task.ranks == 1) task.env.emplace_back("GRANARY_LONE_RANK", "1");  // it needs no mpirun, and starts the sooner
  task.produces = {"restart.liggghts", "tallies.jsonl"};
  return task;
}

Result<pilot::TaskSpec> FileHandover::prepare_pbm(const coupling::StartBurst& start) const {
  pbm::PbmCase burst = campaign_->pbm_case;
  burst.name = start.burst.folder();
  burst.start_time = start.start_time;
  burst.end_time = start.start_time + start.longest;
  if (start.takes_from) {
    GRANARY_TRY(const auto measured, rates_of(*start.takes_from));
    burst.dem = measured.rates;
  }
  if (start.restart) {
    burst.initial.clear();
    burst.restart = pbm::Restart{fs::path("..") / start.restart->folder() / "out.h5", start.restart_time};
  }
  json::Value document = pbm::to_json(burst);
  if (adoption_) document = adoption_(std::move(document), start);
  GRANARY_CHECK(json::write_file(folder(start.burst) / "case.json", document));
  return pbm_task();
}

pilot::TaskSpec FileHandover::pbm_task() const {
  pilot::TaskSpec task;
  task.command = {(programs_ / "granary-pbm").string(),  "run", "case.json", "--out", "out.h5", "--threads",
                  std::to_string(campaign_->pbm.threads)};
  task.ranks = campaign_->pbm.ranks;
  task.threads = campaign_->pbm.threads;
  task.produces = {"out.h5", "progress.jsonl"};
  return task;
}

pilot::TaskSpec FileHandover::monitor_task(const BurstId& burst, int attempt) const {
  const auto& coupling = campaign_->coupling;
  const bool dem = burst.kind == Kind::dem;
  pilot::TaskSpec task;
  task.name = monitor_name(burst, attempt);
  task.light = true;
  task.priority = 10;
  task.retries = 3;  // it only reads: one that was killed begins anew at the burst's first line
  using monitor::Outcome;
  for (const Outcome said : {Outcome::drifted, Outcome::steady, Outcome::converged, Outcome::diverged})
    task.success.set(static_cast<std::size_t>(monitor::exit_code(said)));
  task.dir = fs::path("bursts") / burst.folder();
  task.stop.grace = 10.0;
  task.command = {(programs_ / "granary-monitor").string(),
                  dem ? "dem" : "pbm",
                  ".",
                  "--threshold",
                  fmt::format("{}", coupling.threshold),
                  "--significance",
                  fmt::format("{}", coupling.significance)};
  if (dem) {
    task.command.insert(task.command.end(), {"--grace", fmt::format("{}", coupling.grace), "--steady-window",
                                             fmt::format("{}", coupling.steady_window)});
  }
  return task;
}

std::optional<double> FileHandover::clock(const BurstId& burst, const pilot::TaskEnd&) {
  const auto file = folder(burst) / (burst.kind == Kind::dem ? "tallies.jsonl" : "progress.jsonl");
  const json::Value line = last_line(file);
  if (!line["time_s"].is_number()) return std::nullopt;
  return line["time_s"].as_number();
}

Result<monitor::Verdict> FileHandover::verdict(const BurstId&, const pilot::TaskEnd& monitor) {
  const fs::path out = monitor.dir / (monitor.name + ".out");
  const json::Value line = last_line(out);
  if (line["verdict"].is_string()) return monitor::verdict_from_json(line);
  GRANARY_TRY(const std::string text, read_text(out));
  return Error{fmt::format("the monitor {} ended with exit code {}: {}", monitor.name, monitor.exit_code, text),
               Exit::task_failed};
}

std::string FileHandover::last_words(const pilot::TaskEnd& program) {
  constexpr std::size_t kLines = 8;
  const auto text = read_text(program.dir / (program.name + ".out"));
  if (!text) return program.reason;
  // mpirun says in paragraphs between rules that a rank ended: what the rank itself said is all we want.
  std::vector<std::string> lines;
  std::istringstream in(text->substr(0, text->find("\n-----")));
  for (std::string line; std::getline(in, line);)
    if (line.rfind("-----", 0) != 0 && !line.empty()) lines.push_back(line);
  std::string said = program.reason;
  for (std::size_t i = lines.size() > kLines ? lines.size() - kLines : 0; i < lines.size(); ++i)
    said += "\n" + lines[i];
  return said;
}

Result<coupling::MeasuredRates> FileHandover::rates_of(const BurstId& dem_burst) const {
  return measured(dem_burst, campaign_->coupling.grace);
}

Result<coupling::MeasuredRates> FileHandover::rates_so_far(const BurstId& dem_burst) const {
  return measured(dem_burst, 0.0);
}

Result<coupling::MeasuredRates> FileHandover::measured(const BurstId& dem_burst, double grace) const {
  GRANARY_TRY(const json::Value sampled, json::read_file(folder(dem_burst) / kSampled));
  coupling::RateSettings settings;
  settings.grace = grace;
  settings.law = law_of(campaign_->dem.carry_back);
  if (const auto& found = campaign_->dem.coarse_graining_law)
    settings.found = {found->at, found->collision_rate, found->collision_speed, found->impact_rate,
                      found->impact_speed};
  settings.class_diameter = sampled.numbers("class_diameter_m");
  return coupling::measure_burst(folder(dem_burst), campaign_->pbm_case.compartments.volume, settings);
}

Result<coupling::DemSummary> FileHandover::carry_dem(const coupling::Exchange& exchange) {
  GRANARY_TRY(const auto measured, rates_of(exchange.burst));
  GRANARY_CHECK(json::write_file(folder(exchange.burst) / "rates.json", coupling::to_json(measured)));
  return measured.summary;
}

Result<coupling::PbmSummary> FileHandover::carry_pbm(const coupling::Exchange& exchange) {
  GRANARY_TRY(const auto hold_up, coupling::read_hold_up(folder(exchange.burst) / "out.h5", exchange.time));
  const auto summary = coupling::summarize(hold_up);
  json::Value handover = coupling::to_json(summary);
  GRANARY_CHECK(json::write_file(folder(exchange.burst) / kHandover, handover.set("time_s", hold_up.time)));
  return summary;
}

coupling::Settings coupling_settings(const campaign::Campaign& campaign) {
  const auto& from = campaign.coupling;
  coupling::Settings to;
  switch (from.mode) {
    case campaign::CouplingSettings::Mode::two_way:
      to.mode = coupling::Mode::two_way;
      break;
    case campaign::CouplingSettings::Mode::one_way:
      to.mode = coupling::Mode::one_way;
      break;
    case campaign::CouplingSettings::Mode::pbm_only:
      to.mode = coupling::Mode::pbm_only;
      break;
  }
  to.threshold = from.threshold;
  to.steady_window = from.steady_window;
  to.steady_tolerance = from.steady_tolerance;
  to.significance = from.significance;
  to.grace = from.grace;
  to.longest_dem_burst = campaign.dem.longest_burst;
  to.longest_pbm_burst = campaign.pbm.longest_burst;
  to.least_rounds = from.least_rounds;
  to.most_rounds = from.most_rounds;
  to.process_start = campaign.pbm_case.start_time;
  const pbm::PbmCase& balance = campaign.pbm_case;
  to.earliest_steady = std::max(balance.spray ? balance.spray->start : 0.0, balance.feed ? balance.feed->start : 0.0);
  if (to.earliest_steady > to.process_start) to.earliest_steady += balance.compartments.residence_time.value_or(0.0);
  to.process_duration = campaign.duration - campaign.pbm_case.start_time;
  return to;
}

}  // namespace granary::run
