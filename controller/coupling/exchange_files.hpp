// The files between the programs, read for exchange.hpp. Formats: docs/exchange_formats.md.
#pragma once

#include <filesystem>
#include <optional>

#include "common/result.hpp"
#include "controller/coupling/exchange.hpp"

namespace granary::coupling {

/// tallies.jsonl of a burst that is over. Errors: missing, empty, cut in the middle of a line, or a line that is not
/// what the header promises: file, line, what to do next.
Result<monitor::Tallies> read_tallies(const std::filesystem::path& file);

/// A row of out.h5 or checkpoint.h5: the one written at `time` (none: the last).
/// Errors: not our file; no output at that time (the nearest ones are named); shapes that don't match.
Result<HoldUp> read_hold_up(const std::filesystem::path& file, std::optional<double> time);

/// What the burst in `burst_folder` measured: tallies.jsonl -> rates at real sizes.
Result<MeasuredRates> measure_burst(const std::filesystem::path& burst_folder, const std::vector<double>& bed_volume,
                                    const RateSettings& settings);

/// Normal speed at first touch that only one contact in a thousand exceeded, of collisions and impacts in a
/// tallies.jsonl [m/s]; 0 where fewer than a thousand were counted.
Result<double> fastest_contacts(const std::filesystem::path& file);

}  // namespace granary::coupling
