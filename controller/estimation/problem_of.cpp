#include "controller/estimation/problem_of.hpp"

#include <fmt/format.h>

namespace granary::estimating {
namespace {

bool needs_rates(const pbm::PbmCase& balance) {
  return (balance.aggregation && balance.aggregation->kernel == pbm::Aggregation::Kernel::dem) ||
         (balance.aggregation && balance.aggregation->efficiency.model == pbm::Efficiency::Model::stokes) ||
         (balance.breakage && balance.breakage->selection == pbm::Breakage::Selection::impact);
}

Result<estimation::Experiment> experiment_of(const campaign::Estimation::Experiment& from,
                                             const std::vector<Stretch>& history) {
  estimation::Experiment to{from.name, {}};
  pbm::PbmCase balance = from.balance;
  if (from.rates || !needs_rates(balance)) {
    balance.dem = from.rates;
    to.segments = {pbm::to_json(balance)};
  } else if (history.empty()) {
    return Error{
        fmt::format("the experiment \"{}\" needs the rates of a DEM: give it the \"rates\" of an earlier campaign "
                    "(bursts/NNNN-pbm/case.json in its folder), or estimate within a coupled campaign (granary run).",
                    from.name)};
  } else {
    for (const pbm::PbmCase& segment : segments_of(balance, history)) to.segments.push_back(pbm::to_json(segment));
  }
  return to;
}

}  // namespace

std::vector<pbm::PbmCase> segments_of(const pbm::PbmCase& balance, const std::vector<Stretch>& history) {
  std::vector<pbm::PbmCase> segments;
  double from = balance.start_time;
  for (std::size_t k = 0; k < history.size(); ++k) {
    const bool last = k + 1 == history.size();
    // A process may be over (at its targets) before the campaign's own is.
    if (!last && history[k].until >= balance.end_time) break;
    pbm::PbmCase segment = balance;
    segment.start_time = from;
    segment.end_time = last ? balance.end_time : history[k].until;
    segment.dem = history[k].rates;
    if (k > 0) segment.initial.clear();
    from = segment.end_time;
    segments.push_back(std::move(segment));
  }
  if (!segments.empty()) segments.back().end_time = balance.end_time;
  return segments;
}

Result<estimation::Problem> problem_of(const campaign::Campaign& campaign, const std::vector<Stretch>& history) {
  const campaign::Estimation& from = *campaign.estimation;
  estimation::Problem to;
  for (const auto& parameter : from.parameters) to.parameters.push_back(parameter.is);
  for (const auto& each : from.experiments) {
    GRANARY_TRY(estimation::Experiment experiment, experiment_of(each, history));
    to.experiments.push_back(std::move(experiment));
  }
  to.targets = from.targets;
  return to;
}

}  // namespace granary::estimating
