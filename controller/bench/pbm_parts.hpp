// Starts granary-pbm for each part of the bench and gathers one document. docs/bench.md has its members.
#pragma once

#include <functional>
#include <string>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "controller/bench/effort.hpp"

namespace granary::bench {

/// All parts, one after the other: nothing else of ours runs meanwhile. `say` hears what is done now.
/// Where the machine has one core, or no mpirun, the efficiencies are null and `..._why` says so.
/// Errors: granary-pbm is missing, fails (with what it printed), or prints no JSON.
Result<json::Value> run_pbm_bench(Effort effort, const std::function<void(const std::string&)>& say);

}  // namespace granary::bench
