// What the journal of a campaign with an estimation tells of its cores: how soon idle ones were put to work, how soon
// they were given back, and where they stayed idle.
#pragma once

#include <filesystem>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::bench {

struct IdleCores {
  std::vector<double> put_to_work;  ///< a core falls idle -> an evaluation's process has started, or goes on, there [s]
  std::vector<double> given_back;   ///< a filler is told to give way -> the burst's program has started there [s]
  double before_rates = 0.0;        ///< idle until the first evaluation: there was nothing to fit with [core s]
  double at_switches = 0.0;         ///< idle between one process and the next on a core [core s]
  double afterwards = 0.0;          ///< idle after the last one on a core, until the coupling is over [core s]
};

/// Of one node's campaign, from its begin to the coupling's end. Errors: of read_journal(); no pilot opened it.
Result<IdleCores> idle_cores_of(const std::filesystem::path& journal);

/// {put_to_work_ms, given_back_ms: {p50, p99, most, times}, idle_core_s: {before_rates, at_switches, afterwards}}, of
/// several campaigns together.
json::Value to_json(const std::vector<IdleCores>& campaigns);

}  // namespace granary::bench
