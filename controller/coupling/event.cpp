#include "controller/coupling/event.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace granary::coupling {

namespace {

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <class... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;  // clang 14 does not deduce it by itself

constexpr std::array<std::pair<TaskEnded::Outcome, const char*>, 4> kOutcomes{
    {{TaskEnded::Outcome::finished, "finished"},
     {TaskEnded::Outcome::stopped, "stopped"},
     {TaskEnded::Outcome::failed, "failed"},
     {TaskEnded::Outcome::diverged, "diverged"}}};

const char* name(TaskEnded::Outcome outcome) {
  for (const auto& [value, text] : kOutcomes)
    if (value == outcome) return text;
  return "failed";
}

json::Value event_record(const char* type) { return json::Value::object({{"event", type}}); }

template <class E>
json::Value event_record(const char* type, const E& about) {
  return json::Value::object({{"event", type},
                              {"round", about.burst.round},
                              {"kind", about.burst.kind == Kind::dem ? "dem" : "pbm"},
                              {"attempt", about.attempt}});
}

}  // namespace

std::string BurstId::folder() const { return fmt::format("{:04}-{}", round, kind == Kind::dem ? "dem" : "pbm"); }

json::Value to_json(const Event& event) {
  return std::visit(
      Overloaded{
          [](const Began&) { return event_record("began"); }, [](const Resumed&) { return event_record("resumed"); },
          [](const StopAsked& e) { return event_record("stop_asked").set("message", e.message); },
          [](const TaskStarted& e) { return event_record("task_started", e); },
          [](const MonitorSpoke& e) {
            return event_record("monitor_spoke", e).set("verdict", monitor::to_json(e.verdict));
          },
          [](const MonitorFailed& e) { return event_record("monitor_failed", e).set("message", e.message); },
          [](const TaskEnded& e) {
            return event_record("task_ended", e)
                .set("outcome", name(e.outcome))
                .set("time_s", e.time ? json::Value(*e.time) : json::Value())
                .set("message", e.message);
          },
          [](const DemExchanged& e) { return event_record("dem_exchanged", e).set("summary", to_json(e.summary)); },
          [](const PbmExchanged& e) { return event_record("pbm_exchanged", e).set("summary", to_json(e.summary)); },
          [](const ExchangeFailed& e) { return event_record("exchange_failed", e).set("message", e.message); }},
      event);
}

Result<Event> event_from_json(const json::Value& value) {
  const std::string type = value.text_or("event", "");
  const std::string message = value.text_or("message", "");
  if (type == "began") return Event(Began{});
  if (type == "resumed") return Event(Resumed{});
  if (type == "stop_asked") return Event(StopAsked{message});

  const std::string kind = value.text_or("kind", "");
  const BurstId burst{static_cast<int>(value.integer_or("round", 0)), kind == "pbm" ? Kind::pbm : Kind::dem};
  const int attempt = static_cast<int>(value.integer_or("attempt", 0));
  if (burst.round < 1 || attempt < 1 || (kind != "dem" && kind != "pbm"))
    return Error{
        fmt::format("coupling event \"{}\": /round, /kind and /attempt must name a burst; they are {}, \"{}\" and {}. "
                    "Was the journal "
                    "written by another version of Granary?",
                    type, burst.round, kind, attempt)};
  if (type == "task_started") return Event(TaskStarted{burst, attempt});
  if (type == "monitor_spoke") return Event(MonitorSpoke{burst, attempt, monitor::verdict_from_json(value["verdict"])});
  if (type == "monitor_failed") return Event(MonitorFailed{burst, attempt, message});
  if (type == "dem_exchanged") return Event(DemExchanged{burst, attempt, dem_summary_from_json(value["summary"])});
  if (type == "pbm_exchanged") return Event(PbmExchanged{burst, attempt, pbm_summary_from_json(value["summary"])});
  if (type == "exchange_failed") return Event(ExchangeFailed{burst, attempt, message});
  if (type == "task_ended") {
    const std::string outcome = value.text_or("outcome", "");
    std::optional<double> time;
    if (value["time_s"].is_number()) time = value["time_s"].as_number();
    for (const auto& [known, text] : kOutcomes)
      if (outcome == text) return Event(TaskEnded{burst, attempt, known, time, message});
    return Error{fmt::format(
        "coupling event \"task_ended\": /outcome is \"{}\"; it must be finished, stopped, failed or diverged.",
        outcome)};
  }
  return Error{fmt::format("coupling event: /event is \"{}\", which this version of Granary does not know.", type)};
}

}  // namespace granary::coupling
