// DIR/estimation/evaluations.jsonl: everything that has happened to an estimation, in order, from which it is rebuilt
// with the same trials. Lines (docs/estimation.md#files):
//   {"problem": 2}                                       from here on problem-0002.json holds
//   {"batch": 17, "first": 340, "count": 20}             these trials were asked for, in this batch
//   {"version": 2, "trial": 340, "values": [...], "cost": 3.1, "model": [...], "seconds": 0.02, "time_s": 12.5}
//   {"version": 2, "trial": 341, "values": [...], "cost": null, "failed": "...", "time_s": 12.5}
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "common/json/io.hpp"
#include "common/result.hpp"
#include "estimation/estimator/estimator.hpp"

namespace granary::estimating {

std::filesystem::path problem_file(const std::filesystem::path& folder, int version);

class EvaluationLog {
 public:
  /// What was read again.
  struct Past {
    std::unique_ptr<estimation::Estimator> estimator;       ///< none: nothing was there
    std::map<int, std::vector<estimation::Trial>> waiting;  ///< by batch, of the last version: trials not told of
    int batches = 0;
    double seconds = 0.0;       ///< of all evaluations
    double last_seconds = 0.0;  ///< of the last one
  };

  /// Opens DIR/estimation/evaluations.jsonl, after a torn last line is cut off, and replays it. Errors: a file that
  /// cannot be read or written; a line that is none of these (its number is named).
  static Result<EvaluationLog> open(const std::filesystem::path& folder, const estimation::Settings& settings,
                                    Past& past);

  Status problem(int version);
  Status batch(int number, const std::vector<estimation::Trial>& trials);
  /// `failed`: why; empty: it has an outcome.
  Status trial(int version, long number, const std::vector<double>& values, const estimation::Outcome& outcome,
               const std::string& failed, double seconds, double time);

 private:
  explicit EvaluationLog(json::LineWriter lines) : lines_(std::move(lines)) {}
  json::LineWriter lines_;
};

}  // namespace granary::estimating
