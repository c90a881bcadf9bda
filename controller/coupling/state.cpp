#include "controller/coupling/state.hpp"

namespace granary::coupling {

std::string_view name(Phase phase) {
  switch (phase) {
    case Phase::waiting:
      return "waiting";
    case Phase::running:
      return "running";
    case Phase::stopping:
      return "stopping";
    case Phase::closing:
      return "closing";
    case Phase::exchanging:
      return "exchanging";
    case Phase::ended:
      return "ended";
  }
  return "ended";
}

json::Value to_json(const State& state) {
  json::Value bursts = json::Value::array();
  for (const BurstRecord& burst : state.bursts)
    bursts.push(json::Value::object({{"burst", burst.burst.folder()},
                                     {"attempt", burst.attempt},
                                     {"reason", burst.reason},
                                     {"start_time_s", burst.start_time},
                                     {"end_time_s", burst.end_time},
                                     {"message", burst.message}}));
  return json::Value::object({{"phase", name(state.phase)},
                              {"burst", state.burst.folder()},
                              {"attempt", state.attempt},
                              {"dem_clock_s", state.dem_clock},
                              {"process_clock_s", state.process_clock},
                              {"steady_time_s", state.steady_time},
                              {"stop_asked", state.stop_asked},
                              {"bursts", bursts},
                              {"ended", state.ended ? json::Value(name(*state.ended)) : json::Value()},
                              {"reason", state.why_ended.reason},
                              {"message", state.why_ended.message}});
}

}  // namespace granary::coupling
