// The view as the web page reads it: names with units, columns rather than objects where there are many points.
#include <cmath>

#include "controller/watch/view.hpp"
#include "controller/watch/words.hpp"

namespace granary::watch {

namespace {

using json::Value;

/// The indices to keep of so many points: evenly, first and last included.
std::vector<std::size_t> thinned(std::size_t n, std::size_t most) {
  std::vector<std::size_t> kept;
  const std::size_t wanted = std::min(n, std::max<std::size_t>(most, 2));
  for (std::size_t k = 0; k < wanted; ++k) kept.push_back(wanted < 2 ? 0 : k * (n - 1) / (wanted - 1));
  return kept;
}

Value of(const Burst& burst) {
  return Value::object({{"folder", burst.folder},
                        {"name", burst_words(burst.folder)},
                        {"kind", burst.dem ? "dem" : "pbm"},
                        {"round", burst.round},
                        {"attempt", burst.attempt},
                        {"start_s", burst.start},
                        {"end_s", burst.end},
                        {"longest_s", burst.longest},
                        {"pilot_start_s", burst.pilot_start},
                        {"pilot_end_s", burst.pilot_end},
                        {"why_started", burst.why_started},
                        {"reason", burst.reason},
                        {"message", burst.message},
                        {"particles", burst.particles},
                        {"collision_rate_1_s", burst.collision_rate},
                        {"impact_rate_1_s", burst.impact_rate},
                        {"d50_smallest_m", burst.d50_smallest},
                        {"d50_largest_m", burst.d50_largest}});
}

Value of(const Steadiness& steady) {
  return Value::object({{"quiet_time_s", steady.quiet_time},
                        {"window_s", steady.window},
                        {"rounds", steady.rounds},
                        {"least_rounds", steady.least_rounds},
                        {"most_rounds", steady.most_rounds},
                        {"tolerance", steady.tolerance},
                        {"changed", steady.changed},
                        {"where", steady.where},
                        {"change", steady.change},
                        {"noise", steady.noise},
                        {"dem_quiet", steady.dem_quiet},
                        {"rounds_agree", steady.rounds_agree}});
}

Value sizes_of(const std::vector<SizePoint>& points, std::size_t most) {
  std::vector<double> time;
  std::vector<std::vector<double>> d50;  // of each compartment
  for (const std::size_t k : thinned(points.size(), most)) {
    d50.resize(std::max(d50.size(), points[k].d50.size()), std::vector<double>(time.size(), kUnknown));
    time.push_back(points[k].time);
    for (std::size_t x = 0; x < d50.size(); ++x)
      d50[x].push_back(x < points[k].d50.size() ? points[k].d50[x] : kUnknown);
  }
  return Value::object({{"time_s", time}, {"d50_m", d50}});
}

Value contacts_of(const std::vector<ContactPoint>& points, std::size_t most) {
  std::vector<double> time, particles, collisions, impacts;
  for (const std::size_t k : thinned(points.size(), most)) {
    time.push_back(points[k].time);
    particles.push_back(points[k].particles);
    collisions.push_back(points[k].collisions);
    impacts.push_back(points[k].impacts);
  }
  return Value::object(
      {{"time_s", time}, {"particles", particles}, {"collisions_1_s", collisions}, {"impacts_1_s", impacts}});
}

Value of(const CoreHistory& history) {
  Value busy = Value::object();
  for (const auto& [kind, cores] : history.busy) busy.set(kind, cores);
  return Value::object({{"slice_s", history.slice}, {"busy", busy}});
}

Value of(const RunningTask& task) {
  Value cores = Value::array();
  for (const int core : task.cores) cores.push(core);
  return Value::object({{"name", task.name},
                        {"kind", task.kind},
                        {"state", task.state},
                        {"attempt", task.attempt},
                        {"cores", cores},
                        {"seconds", task.seconds}});
}

Value of(const Fit& fit, std::size_t most) {
  Value parameters = Value::array();
  for (const Fit::Parameter& one : fit.parameters)
    parameters.push(Value::object(
        {{"name", one.name}, {"unit", one.unit}, {"value", one.value}, {"low", one.low}, {"high", one.high}}));
  std::vector<double> time, cost;
  for (const std::size_t k : thinned(fit.points.size(), most)) {
    time.push_back(fit.points[k].time);
    cost.push_back(fit.points[k].cost);
  }
  return Value::object({{"phase", fit.phase},
                        {"evaluations", fit.evaluations},
                        {"misfit", fit.misfit},
                        {"held_out", fit.held_out},
                        {"parameters", parameters},
                        {"time_s", time},
                        {"cost", cost}});
}

const char* name(Level level) {
  return level == Level::warning ? "warning" : level == Level::minor ? "minor" : "usual";
}

}  // namespace

json::Value to_json(const View& view, std::size_t most_points) {
  Value counts = Value::object(), busy = Value::object();
  for (const auto& [state, count] : view.counts) counts.set(state, count);
  for (const auto& [kind, cores] : view.busy_by_kind) busy.set(kind, cores);
  Value tasks = Value::array(), bursts = Value::array(), happenings = Value::array();
  for (const RunningTask& task : view.tasks)
    if (tasks.size() < most_points) tasks.push(of(task));
  for (const Burst& burst : view.bursts) bursts.push(of(burst));
  for (const Happening& one : view.happenings)
    happenings.push(Value::object({{"time_s", one.time}, {"level", name(one.level)}, {"words", one.words}}));
  Value left;
  if (view.time_left)
    left = Value::object(
        {{"least_s", view.time_left->least}, {"most_s", view.time_left->most}, {"how", view.time_left->how}});
  return Value::object({{"campaign", view.campaign},
                        {"folder", view.folder},
                        {"description", view.description},
                        {"coupled", view.coupled},
                        {"mode", view.mode},
                        {"phase", std::string(name(view.phase))},
                        {"headline", view.headline},
                        {"exit", view.exit ? Value(static_cast<int>(*view.exit)) : Value()},
                        {"time_s", view.time},
                        {"nodes", view.nodes},
                        {"cores", view.cores},
                        {"busy_cores", view.busy_cores},
                        {"core_use", view.core_use},
                        {"core_use_fillers", view.core_use_fillers},
                        {"busy_by_kind", busy},
                        {"counts", counts},
                        {"n_tasks", view.tasks.size()},
                        {"tasks", tasks},
                        {"fillers", view.fillers},
                        {"fillers_done", view.fillers_done},
                        {"core_history", of(view.core_history)},
                        {"burst", view.burst ? of(*view.burst) : Value()},
                        {"burst_time_s", view.burst_time},
                        {"bursts", bursts},
                        {"process_time_s", view.process_time},
                        {"process_end_s", view.process_end},
                        {"dem_time_s", view.dem_time},
                        {"sizes", sizes_of(view.sizes, most_points)},
                        {"contacts", contacts_of(view.contacts, most_points)},
                        {"steadiness", view.steadiness ? of(*view.steadiness) : Value()},
                        {"fit", view.fit ? of(*view.fit, most_points) : Value()},
                        {"time_left", left},
                        {"happenings", happenings},
                        {"warnings", Value(view.warnings)}});
}

}  // namespace granary::watch
