#include "pbm_solver/evaluate/experiment_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>

#include "common/json/problems.hpp"
#include "pbm_solver/evaluate/measured.hpp"
#include "pbm_solver/output/state_file.hpp"
#include "pbm_solver/time/simulation.hpp"

namespace granary::pbm {
namespace {

using estimation::Experiment;
using estimation::Problem;
using estimation::Target;

/// CPU time of this thread [s].
double cpu_now() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::string place_of(const Experiment& e, std::size_t segment) {
  return fmt::format("experiment \"{}\", segment {}", e.name, segment);
}

Result<PbmCase> segment_with(const Problem& p, const Experiment& e, std::size_t segment,
                             const std::vector<double>& values) {
  return read_case(estimation::with_parameters(e.segments[segment], p.parameters, values), place_of(e, segment));
}

bool same_classes(const PbmCase& a, const PbmCase& b) {
  return a.grid.bins == b.grid.bins && a.grid.smallest == b.grid.smallest && a.grid.ratio == b.grid.ratio &&
         a.compartments.count == b.compartments.count;
}

/// Why this target cannot be read off that experiment; empty: it can.
std::string fault_of(const Target& t, const PbmCase& first, double start) {
  if (t.time < start) return fmt::format("its time, {:g} s, is before the experiment's start at {:g} s", t.time, start);
  if (t.compartment >= first.compartments.count)
    return fmt::format("compartment {} does not exist; there are {}, from 0", t.compartment, first.compartments.count);
  if (t.compartment == estimation::kOutlet && !first.compartments.residence_time)
    return "it is of the outlet, but nothing flows out: give /compartments/residence_time, or name a compartment";
  return "";
}

}  // namespace

Result<ExperimentModel> ExperimentModel::prepare(Problem problem, const std::string& file) {
  std::string faults;
  const auto fault = [&](const std::string& text) {
    faults += fmt::format("{}{}: {}", faults.empty() ? "" : "\n", file, text);
  };
  const std::vector<double> values = estimation::values_at(problem.parameters, estimation::start_of(problem));
  ExperimentModel model;
  for (const Experiment& e : problem.experiments) {
    Prepared& prepared = model.prepared_.emplace_back();
    std::optional<PbmCase> first;
    for (std::size_t s = 0; s < e.segments.size(); ++s) {
      const auto segment = segment_with(problem, e, s, values);
      if (!segment)
        fault(segment.error().message);
      else if (s == 0)
        first = *segment;
      else if (first && !same_classes(*first, *segment))
        fault(place_of(e, s) + " has other classes or compartments than the first.");
    }
    if (!first) continue;
    if (first->restart) {
      auto start = read_restart(*first->restart, *first, ClassGrid(first->grid));
      if (!start) {
        fault(start.error().message);
        continue;
      }
      prepared.start = *std::move(start);
    }
    const double start = prepared.start ? prepared.start->time : first->start_time;
    for (std::size_t t = 0; t < problem.targets.size(); ++t) {
      if (problem.targets[t].experiment != e.name) continue;
      prepared.stops.push_back({problem.targets[t].time, t});
      if (const std::string why = fault_of(problem.targets[t], *first, start); !why.empty())
        fault(fmt::format("/targets/{}: {}.", t, why));
    }
    std::stable_sort(prepared.stops.begin(), prepared.stops.end(),
                     [](const Stop& a, const Stop& b) { return a.time < b.time; });
  }
  if (!faults.empty()) return Error{faults};
  model.problem_ = std::move(problem);
  return model;
}

Result<std::vector<double>> ExperimentModel::run(const std::vector<double>& values, double seconds_at_most) const {
  std::vector<std::vector<double>> results(problem_.targets.size());
  const double deadline = cpu_now() + seconds_at_most;
  for (std::size_t e = 0; e < problem_.experiments.size(); ++e)
    GRANARY_CHECK(run_experiment(e, values, deadline, results));
  std::vector<double> all;
  for (const auto& one : results) all.insert(all.end(), one.begin(), one.end());
  return all;
}

Status ExperimentModel::run_experiment(std::size_t experiment, const std::vector<double>& values, double deadline,
                                       std::vector<std::vector<double>>& results) const {
  const Experiment& e = problem_.experiments[experiment];
  std::optional<Snapshot> state = prepared_[experiment].start;
  auto stop = prepared_[experiment].stops.begin();
  const auto end = prepared_[experiment].stops.end();
  for (std::size_t s = 0; s < e.segments.size() && stop != end; ++s) {
    GRANARY_TRY(const PbmCase c, segment_with(problem_, e, s, values));
    const ClassGrid grid(c.grid);
    if (!state) state = initial_snapshot(c, grid);
    const bool last = s + 1 == e.segments.size();
    Alone alone(c.compartments.count);
    Simulation simulation(c, *state, alone, 1);
    for (;;) {
      for (; stop != end && stop->time <= state->time; ++stop)
        results[stop->target] = measured(problem_.targets[stop->target], *state, c, grid);
      if (stop == end || (!last && state->time >= c.end_time)) break;
      const double until = last ? stop->time : std::min(stop->time, c.end_time);
      GRANARY_TRY(const bool reached, simulation.advance(until, [&] { return cpu_now() < deadline; }));
      if (!reached)
        return Error{fmt::format("{}: the time of a trial was up at {:g} s", place_of(e, s), simulation.time())};
      state = simulation.snapshot();
    }
  }
  return {};
}

}  // namespace granary::pbm
