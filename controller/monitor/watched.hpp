// Which properties of a burst are watched: turns the lines of tallies.jsonl or progress.jsonl into the rows
// criteria.hpp judges.
//   DEM: mean speed of each size class, collisions and impacts per time (all classes, all bodies)
//   PBM: d50 and particle number of each compartment
// What is too thin to judge by is left out: docs/coupling.md#what-is-watched.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "controller/monitor/criteria.hpp"
#include "controller/monitor/tallies.hpp"

namespace granary::monitor {

enum class Program { dem, pbm };

std::string_view watched_file(Program program);  ///< "tallies.jsonl", "progress.jsonl"

/// Particles a class (DEM), counts a mean over rows (DEM), and share of the fullest compartment's solid (PBM), below
/// which a property is left out, or its change measured against this floor.
inline constexpr double kLeastParticles = 20.0;
inline constexpr double kLeastCounts = 20.0;
inline constexpr double kLeastShare = 0.05;

/// Defaults of each program: a DEM averages 3 windows and grants 0.2 s; a PBM's rows are exact.
Options default_options(Program program);

class Watch {
 public:
  /// @param file  names the place of a bad line in messages
  Watch(Program program, Options options, std::string file);

  /// The next line of the file. The first verdict other than `none` is final.
  /// Errors: a line that is not what the format promises: file, line number, member, what to do.
  Result<Verdict> take(const json::Value& line);
  Verdict ended() const;
  std::size_t lines() const { return line_; }  ///< taken so far, with the header

 private:
  Verdict diverged(std::string cause_message, double time, json::Value record) const;
  Result<Verdict> take_tally(const json::Value& line, const std::string& place);
  Result<Verdict> take_progress(const json::Value& line, const std::string& place);

  Program program_;
  Options options_;
  std::string file_;
  std::size_t line_ = 0;               ///< lines taken
  std::optional<TallyHeader> header_;  ///< DEM
  std::size_t n_compartments_ = 0;     ///< PBM
  std::optional<Criteria> criteria_;   ///< once the header is known
};

/// The verdict on a file that will not grow any more (a finished burst).
/// Errors: missing or torn file, or a bad line.
Result<Verdict> judge_file(Program program, const Options& options, const std::filesystem::path& file);

}  // namespace granary::monitor
