// Keeps idle cores busy with an estimation: turns its trials into `fill` tasks of the pilot, many trials to a task, and
// their results back. Owns DIR/estimation/ (docs/estimation.md#files), from which it goes on after any end. Has no loop
// of its own: a host (a campaign, or `granary estimate`) submits its tasks and tells it of their ends.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "controller/estimation/evaluation_log.hpp"
#include "estimation/estimator/estimator.hpp"
#include "pilot/task/spec.hpp"
#include "pilot/task/state.hpp"

namespace granary::estimating {

struct CrewSettings {
  std::filesystem::path dir;      ///< the campaign's folder
  std::filesystem::path program;  ///< granary-pbm
  int cores = 1;                  ///< that may fall idle: so many tasks and a few more are kept waiting or running
  estimation::Settings search;
  bool until_done = false;  ///< asks for no more than the intervals need; else it samples on, as long as cores idle
};

class Crew {
 public:
  explicit Crew(CrewSettings settings);

  /// Begins, or goes on with what DIR/estimation holds: where `problem` is not the one it ended with, as after
  /// change(). Errors: the folder cannot be written, or is damaged (file and line are named).
  Status begin(const estimation::Problem& problem);
  bool begun() const { return estimator_ != nullptr; }
  /// New rates: a new version, of the same parameters. The names of tasks whose results nobody needs any more.
  Result<std::vector<std::string>> change(const estimation::Problem& problem);

  /// To be submitted now. After begin() those of the earlier life first, under their old names: the pilot may know
  /// them.
  Result<std::vector<pilot::TaskSpec>> next();
  /// Of every task that has ended; others' are ignored. Error: the estimation cannot go on (the programs refuse the
  /// problem, or the disk is full); the campaign can.
  Status ended(const pilot::TaskEnd& end);

  /// Tasks whose results would still be taken.
  std::vector<std::string> open() const;

  /// Nothing more to ask, or (until_done) nothing more to know.
  bool done() const;
  int version() const { return begun() ? estimator_->version() : 0; }
  /// Cheap. None before there is one of this version.
  std::optional<estimation::Fitted> best() const;
  /// All that is known of it. Some milliseconds late in a long estimation: the intervals are worked out anew.
  estimation::Estimate estimate() const;
  const estimation::Estimator& estimator() const { return *estimator_; }
  /// Evaluations of the present version.
  long evaluated_now() const { return begun() ? estimator_->evaluated_now() : 0; }
  /// What best.json says: the estimate, {"phase", "asked", "evaluated", "failed", "late", "seconds" of computing}.
  json::Value status() const;
  /// Now; else it is done now and then.
  Status write_best() const;

 private:
  struct Batch {
    int number = 0;
    std::vector<estimation::Trial> trials;  ///< not yet told of
    bool submitted = false;                 ///< in this life
  };

  Status set_problem(const estimation::Problem& problem, int version);
  Status add_batch();
  int trials_for_a_batch() const;
  Status write_trials(const Batch& batch) const;
  pilot::TaskSpec task_of(const Batch& batch) const;
  Status take_results(Batch& batch, double time);
  Status report_now_and_then();
  void remove_files(int batch) const;
  std::filesystem::path file_of(int batch, const char* suffix) const;  ///< relative to DIR

  CrewSettings settings_;
  std::filesystem::path folder_;  ///< DIR/estimation
  std::unique_ptr<estimation::Estimator> estimator_;
  std::optional<EvaluationLog> log_;
  std::map<std::string, Batch> open_;  ///< by the name of their task
  std::map<std::string, int> stale_;   ///< tasks of an older version that may still run: their batches
  int batches_ = 0;                    ///< so many were made
  double seconds_ = 0.0;               ///< of all evaluations
  double each_ = 0.0;                  ///< seconds of an evaluation, lately; 0: unknown
  bool exhausted_ = false;             ///< the estimator has no more to ask
  int fruitless_ = 0;                  ///< batches one after the other that brought nothing
  long reported_ = -1;                 ///< evaluations when best.json was written
  estimation::Phase reported_phase_ = estimation::Phase::search;
};

}  // namespace granary::estimating
