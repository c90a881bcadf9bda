#include "controller/coupling/action.hpp"

namespace granary::coupling {

namespace {

json::Value to_json(const Why& why) {
  return json::Value::object({{"reason", why.reason}, {"message", why.message}, {"numbers", why.numbers}});
}

template <class A>
json::Value action_record(const char* type, const A& action) {
  return json::Value::object({{"action", type}, {"burst", action.burst.folder()}, {"attempt", action.attempt}});
}

json::Value folder_or_null(const std::optional<BurstId>& burst) {
  return burst ? json::Value(burst->folder()) : json::Value();
}

struct ToJson {
  json::Value operator()(const StartBurst& a) const {
    return action_record("start_burst", a)
        .set("start_time_s", a.start_time)
        .set("longest_s", a.longest)
        .set("restart", folder_or_null(a.restart))
        .set("restart_time_s", a.restart ? json::Value(a.restart_time) : json::Value())
        .set("takes_from", folder_or_null(a.takes_from))
        .set("monitored", a.monitored)
        .set("watch_drift", a.watch_drift)
        .set("why", to_json(a.why));
  }
  json::Value operator()(const StopTask& a) const { return action_record("stop_task", a).set("why", to_json(a.why)); }
  json::Value operator()(const AskMonitor& a) const {
    return action_record("ask_monitor", a).set("why", to_json(a.why));
  }
  json::Value operator()(const Exchange& a) const {
    return action_record("exchange", a).set("time_s", a.time).set("why", to_json(a.why));
  }
  json::Value operator()(const End& a) const {
    return json::Value::object({{"action", "end"}, {"how", name(a.how)}, {"why", to_json(a.why)}});
  }
};

}  // namespace

std::string_view name(End::How how) {
  switch (how) {
    case End::How::steady:
      return "steady";
    case End::How::limit:
      return "limit";
    case End::How::stopped:
      return "stopped";
    case End::How::failed:
      return "failed";
  }
  return "failed";
}

json::Value to_json(const Action& action) { return std::visit(ToJson{}, action); }

}  // namespace granary::coupling
