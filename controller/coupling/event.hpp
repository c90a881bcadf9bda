// What the coupling is told. Each event names the burst and the attempt it is about, so a late or a repeated one does
// no harm. Events are journalled before they are acted on: to_json/event_from_json give them back bit for bit.
#pragma once

#include <compare>
#include <optional>
#include <string>
#include <variant>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "controller/coupling/summary.hpp"
#include "controller/monitor/verdict.hpp"

namespace granary::coupling {

enum class Kind { dem, pbm };

/// bursts/0003-pbm/ is {3, pbm}: the PBM burst of the third round.
struct BurstId {
  int round = 0;  ///< from 1
  Kind kind = Kind::dem;

  auto operator<=>(const BurstId&) const = default;
  std::string folder() const;  ///< "0003-pbm"
};

/// The campaign begins.
struct Began {
  bool operator==(const Began&) const = default;
};

/// The controller is back after it was stopped or killed; no task of before is running any more.
struct Resumed {
  bool operator==(const Resumed&) const = default;
};

/// The user, or the walltime, wants an end: graceful, resumable.
struct StopAsked {
  std::string message;
  bool operator==(const StopAsked&) const = default;
};

/// The pilot has started a (further) attempt of the burst's program.
struct TaskStarted {
  BurstId burst;
  int attempt = 1;
  bool operator==(const TaskStarted&) const = default;
};

/// The burst's monitor has ended with a verdict (Outcome::ended: it saw nothing to report up to the program's end).
struct MonitorSpoke {
  BurstId burst;
  int attempt = 1;
  monitor::Verdict verdict;
  bool operator==(const MonitorSpoke&) const = default;
};

/// The burst's monitor could not do its work (exit code 2, or it was killed for good).
struct MonitorFailed {
  BurstId burst;
  int attempt = 1;
  std::string message;
  bool operator==(const MonitorFailed&) const = default;
};

/// The burst's program has ended, and no retry will follow.
struct TaskEnded {
  enum class Outcome { finished, stopped, failed, diverged };  ///< exit code 0 by itself; 0 as we asked; 20 is diverged
  BurstId burst;
  int attempt = 1;
  Outcome outcome = Outcome::finished;
  std::optional<double> time;  ///< its clock when it ended [s], if known
  std::string message;         ///< why it failed, in words that help
  bool operator==(const TaskEnded&) const = default;
};

/// The rates of a DEM burst have been handed to the next PBM burst.
struct DemExchanged {
  BurstId burst;
  int attempt = 1;
  DemSummary summary;
  bool operator==(const DemExchanged&) const = default;
};

/// The sizes of a PBM burst have been handed to the next DEM burst.
struct PbmExchanged {
  BurstId burst;
  int attempt = 1;
  PbmSummary summary;
  bool operator==(const PbmExchanged&) const = default;
};

struct ExchangeFailed {
  BurstId burst;
  int attempt = 1;
  std::string message;
  bool operator==(const ExchangeFailed&) const = default;
};

using Event = std::variant<Began, Resumed, StopAsked, TaskStarted, MonitorSpoke, MonitorFailed, TaskEnded, DemExchanged,
                           PbmExchanged, ExchangeFailed>;

json::Value to_json(const Event& event);
/// Errors: an unknown or incomplete event names the member (the journal was written by another version).
Result<Event> event_from_json(const json::Value& value);

}  // namespace granary::coupling
