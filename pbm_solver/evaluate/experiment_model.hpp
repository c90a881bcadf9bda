// A problem's experiments by the solver: parameters in, the targets' values out. In memory, one thread, no files but
// the state an experiment may begin with.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "estimation/problem/problem.hpp"
#include "pbm_solver/time/snapshot.hpp"

namespace granary::pbm {

class ExperimentModel {
 public:
  /// Every problem at once: a segment that is no case, segments of different grids, a target before the start, of a
  /// compartment there is not, or of the outlet of a row without flow. `file` opens the messages.
  static Result<ExperimentModel> prepare(estimation::Problem problem, const std::string& file);

  const estimation::Problem& problem() const { return problem_; }

  /// The values of all targets, in their order, SI (of a distribution: its shares), shape (sum of the targets' sizes).
  /// @param values           of the parameters
  /// @param seconds_at_most  of this thread's CPU time: a process that was suspended has not used it up
  /// Errors: a case that such values make impossible; a tolerance that cannot be kept; the time is up.
  Result<std::vector<double>> run(const std::vector<double>& values, double seconds_at_most) const;

 private:
  struct Stop {
    double time;
    std::size_t target;  ///< index into the problem's
  };
  struct Prepared {
    std::optional<Snapshot> start;  ///< of a file
    std::vector<Stop> stops;        ///< by time
  };
  Status run_experiment(std::size_t experiment, const std::vector<double>& values, double deadline,
                        std::vector<std::vector<double>>& results) const;

  estimation::Problem problem_;
  std::vector<Prepared> prepared_;  ///< one an experiment
};

}  // namespace granary::pbm
