// Follows DIR/estimation from outside: the best fit as best.json has it, and how the objective fell.
#pragma once

#include <filesystem>
#include <optional>

#include "common/json/io.hpp"
#include "controller/watch/view.hpp"

namespace granary::watch {

class EstimationFiles {
 public:
  /// `dir` is the run directory.
  explicit EstimationFiles(const std::filesystem::path& dir);

  /// Reads what is new. `understood`: the estimation as campaign.json has it, for units. Nothing before the first
  /// evaluation.
  std::optional<Fit> look(const json::Value& understood);

 private:
  std::filesystem::path best_;
  json::LineReader evaluations_;
  Fit fit_;
  std::int64_t version_ = 0;  ///< of the rates that the last evaluation was made with
};

}  // namespace granary::watch
