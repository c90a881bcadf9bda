// An estimation in words and numbers: while it runs, and at its end.
#pragma once

#include <filesystem>
#include <string>

#include "common/json/value.hpp"
#include "controller/campaign/estimation.hpp"
#include "controller/estimation/crew.hpp"
#include "pilot/pilot.hpp"

namespace granary::estimating {

/// "search: 240 evaluations, chi^2 per datum 1.32, aggregation rate 0.21, ..."
std::string progress_text(const Crew& crew, const campaign::Estimation& estimation);

/// Crew::status() with {"fit": [{experiment, quantity, time_s, compartment, measured, model, error, held_out}],
/// "wall_s", "cores", "core_use", "evaluations_per_s", "dir"}.
json::Value report_json(const Crew& crew, const estimation::Problem& problem, const pilot::Usage& usage, double wall,
                        const std::filesystem::path& dir);
/// The same for people.
std::string report_text(const json::Value& report, const campaign::Estimation& estimation);

}  // namespace granary::estimating
