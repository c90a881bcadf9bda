#include "controller/run/campaign_estimation.hpp"

#include <fmt/format.h>

#include <utility>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "common/log.hpp"
#include "controller/estimation/adoption.hpp"
#include "controller/estimation/crew_settings.hpp"

namespace granary::run {
namespace fs = std::filesystem;
using campaign::Estimation;
using coupling::Kind;

namespace {

constexpr double kLookEvery = 0.1;  // for first rates [s]
constexpr const char* kAdopted = "estimation.adopted";
constexpr const char* kOver = "estimation.over";  // the coupling's end, before the final run

std::vector<estimation::Parameter> parameters_of(const Estimation& estimation) {
  std::vector<estimation::Parameter> parameters;
  for (const auto& parameter : estimation.parameters) parameters.push_back(parameter.is);
  return parameters;
}

std::string told_to_people(const Estimation& estimation, const std::vector<double>& values) {
  std::string text;
  for (std::size_t k = 0; k < values.size(); ++k)
    text += fmt::format("{}{} {}", k > 0 ? ", " : "", estimation.parameters[k].is.name,
                        campaign::shown(values[k], estimation.parameters[k].unit));
  return text;
}

}  // namespace

CampaignEstimation::CampaignEstimation(const campaign::Campaign& campaign, fs::path dir, fs::path programs,
                                       FileHandover& handover, pilot::Pilot& pilot, pilot::EventLoop& loop,
                                       pilot::Journal& journal, std::function<void(const std::string&)> note)
    : campaign_(campaign),
      dir_(std::move(dir)),
      programs_(std::move(programs)),
      handover_(handover),
      pilot_(pilot),
      loop_(loop),
      journal_(journal),
      note_(std::move(note)),
      crew_(estimating::crew_settings(*campaign.estimation, dir_, programs_, pilot.machine().n_cores())) {}

Status CampaignEstimation::begin(const coupling::State& state) {
  if (const auto before = journal_.records(kAdopted); !before.empty()) {
    earlier_best_ = estimating::fitted_of(before.back().payload);
  }
  GRANARY_TRY(const auto stretches, history(state));
  GRANARY_CHECK(work_on(stretches));
  if (!state.ended) submit_fillers();
  return {};
}

void CampaignEstimation::told(const coupling::Event& event, const coupling::State& state) {
  if (given_up_ || state.ended) return;
  if (const auto* started = std::get_if<coupling::TaskStarted>(&event); started && started->burst.kind == Kind::dem)
    return await_rates(started->burst);
  if (!std::holds_alternative<coupling::DemExchanged>(event)) return;
  const auto stretches = history(state);
  const Status worked = stretches ? work_on(*stretches) : Status(stretches.error());
  worked ? submit_fillers() : give_up(worked.error());
}

/// The first burst's cores are not all there are: the others begin with what it has counted by now. Its last line may
/// be half written: the next look finds it whole.
void CampaignEstimation::await_rates(const coupling::BurstId& dem_burst) {
  loop_.cancel(awaiting_);
  if (crew_.begun() || given_up_ || pilot_.stopping()) return;
  if (const auto measured = handover_.rates_so_far(dem_burst)) {
    const Status worked = work_on({{0.0, measured->rates}});
    worked ? submit_fillers() : give_up(worked.error());
  } else {
    awaiting_ = loop_.after(kLookEvery, [this, dem_burst] { await_rates(dem_burst); });
  }
}

/// The rates that were measured so far, each up to the end of its PBM burst.
Result<std::vector<estimating::Stretch>> CampaignEstimation::history(const coupling::State& state) {
  std::vector<estimating::Stretch> stretches;
  for (const coupling::BurstRecord& over : state.bursts) {
    if (over.burst.kind == Kind::pbm) {
      if (!stretches.empty()) stretches.back().until = over.end_time;
      continue;
    }
    if (state.phase == coupling::Phase::exchanging && over.burst == state.burst) break;  // not handed over yet
    if (rates_.count(over.burst.round) == 0) {
      GRANARY_TRY(auto measured, handover_.rates_of(over.burst));
      rates_[over.burst.round] = std::move(measured.rates);
    }
    stretches.push_back({over.end_time, rates_[over.burst.round]});
  }
  return stretches;
}

Status CampaignEstimation::work_on(const std::vector<estimating::Stretch>& stretches) {
  const auto problem = estimating::problem_of(campaign_, stretches);
  if (!problem) return stretches.empty() ? Status() : problem.error();  // before the first rates there is nothing to do
  if (!crew_.begun()) {
    GRANARY_CHECK(crew_.begin(*problem));
  } else {
    earlier_best_ = known_best();
    GRANARY_TRY(const auto stale, crew_.change(*problem));
    for (const std::string& name : stale)
      if (const auto id = pilot_.find(name)) pilot_.stop(*id, "there are new rates");
  }
  return {};
}

void CampaignEstimation::submit_fillers() {
  if (given_up_ || pilot_.stopping()) return;
  auto tasks = crew_.next();
  if (!tasks) return give_up(tasks.error());
  for (pilot::TaskSpec& task : *tasks) {
    fillers_.insert(task.name);
    if (const auto submitted = pilot_.submit(std::move(task)); !submitted) return give_up(submitted.error());
  }
}

void CampaignEstimation::stop_fillers(const std::string& reason) {
  for (const std::string& name : std::exchange(fillers_, {}))
    if (const auto id = pilot_.find(name)) pilot_.stop(*id, reason);
}

/// The campaign goes on without.
void CampaignEstimation::give_up(const Error& error) {
  given_up_ = true;
  log::warning("estimation", error.message);
  note_("the estimation cannot go on: " + error.message);
  stop_fillers("the estimation cannot go on");
}

void CampaignEstimation::task_ended(const pilot::TaskEnd& end) {
  if (final_tasks_.erase(end.name) != 0) {
    if (end.state != pilot::TaskState::finished && !pilot_.stopping()) {
      note_(fmt::format("the final run failed: {}", handover_.last_words(end)));
      final_tasks_.clear();
    }
    if (final_tasks_.empty() && done_) std::exchange(done_, nullptr)();
    return;
  }
  const bool ours = fillers_.erase(end.name) != 0;
  if (!ours || given_up_) return;
  if (const Status taken = crew_.ended(end); !taken) return give_up(taken.error());
  submit_fillers();
}

/// With new rates the best points of before are tried first; until that is done, what was best before still counts.
std::optional<estimation::Fitted> CampaignEstimation::known_best() const {
  const auto tried_first = static_cast<long>(2 * campaign_.estimation->parameters.size() + 4);
  return crew_.evaluated_now() > tried_first ? crew_.best() : earlier_best_;
}

json::Value CampaignEstimation::adopted(json::Value pbm_case, const coupling::StartBurst& start) {
  if (campaign_.estimation->adopt != Estimation::Adopt::continuously) return pbm_case;
  const auto best = known_best();
  if (!best) return pbm_case;
  json::Value record = estimating::record_of(*best, pilot_.now());
  record.set("burst", start.burst.folder()).set("attempt", start.attempt);
  if (const Status written = journal_.append(kAdopted, record); !written) return pbm_case;  // the next event says why
  note_(fmt::format("{} adopts {} (half sum of squares {:.4g})", start.burst.folder(),
                    told_to_people(*campaign_.estimation, best->values), best->cost));
  return estimation::with_parameters(std::move(pbm_case), parameters_of(*campaign_.estimation), best->values);
}

// ---- the final run

void CampaignEstimation::finish(const coupling::State& state, std::function<void()> done) {
  stop_fillers("the coupling is over");
  loop_.cancel(awaiting_);
  given_up_ = true;  // asks for nothing more
  if (const json::Value over = json::Value::object({{"time_s", pilot_.now()}}); journal_.records(kOver).empty())
    (void)journal_.append(kOver, over);
  if (campaign_.estimation->adopt == Estimation::Adopt::never) return done();
  done_ = std::move(done);
  if (const Status started = start_final_run(state); !started) {
    note_("no final run: " + started.error().message);
    final_tasks_.clear();
    std::exchange(done_, nullptr)();
  }
}

/// The balance over the whole process with the parameters as estimated and the rates of each burst: a task a stretch,
/// each from the end of the one before.
Status CampaignEstimation::start_final_run(const coupling::State& state) {
  GRANARY_TRY(const std::vector<double> values, estimating::final_values(journal_, known_best(), pilot_.now()));
  GRANARY_TRY(const auto stretches, history(state));
  note_("the final run begins, with " + told_to_people(*campaign_.estimation, values));
  auto segments =
      stretches.empty() ? std::vector{campaign_.pbm_case} : estimating::segments_of(campaign_.pbm_case, stretches);
  std::vector<pilot::TaskSpec> tasks;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const std::string folder = fmt::format("{:04}", k + 1);
    pbm::PbmCase& segment = segments[k];
    segment.name = "final-" + folder;
    if (k > 0) segment.restart = pbm::Restart{fs::path("..") / fmt::format("{:04}", k) / "out.h5", segment.start_time};
    const json::Value document =
        estimation::with_parameters(pbm::to_json(segment), parameters_of(*campaign_.estimation), values);
    GRANARY_CHECK(make_folders(dir_ / "final" / folder));
    GRANARY_CHECK(json::write_file(dir_ / "final" / folder / "case.json", document));
    pilot::TaskSpec task = handover_.pbm_task();
    task.name = segment.name + "-pbm";
    task.dir = fs::path("final") / folder;
    if (k > 0) task.after = {tasks.back().name};
    tasks.push_back(std::move(task));
  }
  for (const pilot::TaskSpec& task : tasks) final_tasks_.insert(task.name);
  for (pilot::TaskSpec& task : tasks) GRANARY_CHECK(pilot_.submit(std::move(task)));
  return {};
}

}  // namespace granary::run
