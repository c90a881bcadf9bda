// What estimation finds and what it costs: `granary bench estimation` (docs/estimation.md#figures).
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "controller/bench/effort.hpp"

namespace granary::bench {

struct EstimationBench {
  Effort effort = Effort::usual;
  std::filesystem::path dir;       ///< an empty folder to work in
  std::filesystem::path workflow;  ///< a coupled campaign with an estimation, run on and off; empty: left out
  int cores = 0;                   ///< 0: all of this machine
};

/// {"methods": [{name, parameters, recovered_share, evaluations_median, core_use, ...}], "product",
/// "coupled_slowdown", "core_use_on", "core_use_off" (null without a workflow), "coupled": {...}}.
Result<json::Value> run_estimation_bench(const EstimationBench& bench,
                                         const std::function<void(const std::string&)>& say);
/// As tables.
std::string estimation_table(const json::Value& document);

}  // namespace granary::bench
