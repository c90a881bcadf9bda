// What a monitor says about a running burst. The words, the exit codes and the JSON line are in
// docs/exchange_formats.md.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "common/json/value.hpp"

namespace granary::monitor {

enum class Outcome {
  none,       ///< nothing to say yet
  ended,      ///< the task ended, or we were told to stop, before anything else was seen
  drifted,    ///< a watched property moved by more than the threshold since the burst began
  steady,     ///< no watched property moved by more than the threshold over the steady window
  converged,  ///< the standard errors of the watched means are below the tolerance
  diverged,   ///< the program says that its run makes no sense any more
};

std::string_view name(Outcome outcome);  ///< "drifted"
std::optional<Outcome> outcome_named(std::string_view name);
int exit_code(Outcome outcome);  ///< 10 drifted, 11 steady, 12 converged, 20 diverged, 0 otherwise

/// A verdict with the numbers that led to it. `watched`/`where` name the property that decided: it moved most.
struct Verdict {
  Outcome outcome = Outcome::none;
  std::string watched;       ///< "d50_m", "collisions_per_particle_s", ...; "" if no single property decided
  std::string where;         ///< "compartment 2", "class 3", "all"
  double reference = 0.0;    ///< the property's value at the start (drifted), its mean (steady, converged)
  double value = 0.0;        ///< the property's value now
  double change = 0.0;       ///< (value - reference) / |reference|; steady: (max - min) / mean; converged: rel. error
  double threshold = 0.0;    ///< what `change` was held against
  double noise = 0.0;        ///< standard error of `change` by counting statistics [-]
  double time = 0.0;         ///< clock of the program at the line that decided [s]
  double burst_start = 0.0;  ///< [s]
  std::size_t lines = 0;     ///< lines read, without the header
  std::string message;       ///< one sentence for a person
  json::Value details;       ///< diverged: the program's own record, word for word

  bool operator==(const Verdict&) const = default;
};

json::Value to_json(const Verdict& verdict);
Verdict verdict_from_json(const json::Value& value);

}  // namespace granary::monitor
