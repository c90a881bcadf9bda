#include "controller/monitor/verdict.hpp"

#include <array>
#include <utility>

namespace granary::monitor {

namespace {
constexpr std::array<std::pair<Outcome, std::string_view>, 6> kNames{{{Outcome::none, "none"},
                                                                      {Outcome::ended, "ended"},
                                                                      {Outcome::drifted, "drifted"},
                                                                      {Outcome::steady, "steady"},
                                                                      {Outcome::converged, "converged"},
                                                                      {Outcome::diverged, "diverged"}}};
}  // namespace

std::string_view name(Outcome outcome) {
  for (const auto& [value, text] : kNames)
    if (value == outcome) return text;
  return "none";
}

std::optional<Outcome> outcome_named(std::string_view text) {
  for (const auto& [value, known] : kNames)
    if (known == text) return value;
  return std::nullopt;
}

int exit_code(Outcome outcome) {
  switch (outcome) {
    case Outcome::drifted:
      return 10;
    case Outcome::steady:
      return 11;
    case Outcome::converged:
      return 12;
    case Outcome::diverged:
      return 20;
    case Outcome::none:
    case Outcome::ended:
      return 0;
  }
  return 0;
}

json::Value to_json(const Verdict& verdict) {
  auto value = json::Value::object({{"verdict", name(verdict.outcome)},
                                    {"watched", verdict.watched},
                                    {"where", verdict.where},
                                    {"reference", verdict.reference},
                                    {"value", verdict.value},
                                    {"change", verdict.change},
                                    {"threshold", verdict.threshold},
                                    {"noise", verdict.noise},
                                    {"time_s", verdict.time},
                                    {"burst_start_s", verdict.burst_start},
                                    {"lines", verdict.lines},
                                    {"message", verdict.message}});
  if (!verdict.details.is_null()) value.set("details", verdict.details);
  return value;
}

Verdict verdict_from_json(const json::Value& value) {
  Verdict verdict;
  verdict.outcome = outcome_named(value.text_or("verdict", "none")).value_or(Outcome::none);
  verdict.watched = value.text_or("watched", "");
  verdict.where = value.text_or("where", "");
  verdict.reference = value.number_or("reference", 0.0);
  verdict.value = value.number_or("value", 0.0);
  verdict.change = value.number_or("change", 0.0);
  verdict.threshold = value.number_or("threshold", 0.0);
  verdict.noise = value.number_or("noise", 0.0);
  verdict.time = value.number_or("time_s", 0.0);
  verdict.burst_start = value.number_or("burst_start_s", 0.0);
  verdict.lines = static_cast<std::size_t>(value.integer_or("lines", 0));
  verdict.message = value.text_or("message", "");
  verdict.details = value["details"];
  return verdict;
}

}  // namespace granary::monitor
