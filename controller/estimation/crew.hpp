// Keeps idle cores busy with an estimation: turns its trials into `fill` tasks of the pilot, many trials to a task, and
// their results back. Owns DIR/estimation/ (docs/estimation.md#files), from which it goes on after any end. Has no loop
// of its own: a host (a campaign, or `granary estimate`) submits its tasks and tells it of their ends.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/json/io.hpp"
#include "common/result.hpp"
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

  /// Nothing more to ask, or (until_done) nothing more to know.
  bool done() const;
  int version() const { return version_; }
  estimation::Phase phase() const;
  /// The best trial and all that is known of it; `trial` is -1 before there is one. Some milliseconds late in a long
  /// estimation: the intervals are worked out anew.
  estimation::Estimate estimate() const;
  /// Cheap: the best trial's values alone.
  struct Best {
    std::vector<double> values;
    int version;
    long trial;
    double cost;
  };
  std::optional<Best> best() const;
  /// What best.json says: estimate, phase, counts, seconds of computing.
  json::Value status() const;

 private:
  struct Batch {
    int number = 0;
    int version = 1;
    std::vector<estimation::Trial> trials;  ///< not yet told of
    bool submitted = false;                 ///< in this life
    bool long_one = false;                  ///< of the posterior
  };

  Status replay();
  Status open_log();
  Status write_problem(const estimation::Problem& problem);
  Status write_best() const;
  Result<Batch> make_batch();
  Status write_trials(const Batch& batch) const;
  pilot::TaskSpec task_of(const Batch& batch) const;
  Status log(const json::Value& line);
  Status take(Batch& batch);
  void close(int number);
  int trials_for_a_batch() const;
  std::filesystem::path file_of(int batch, const char* suffix) const;

  CrewSettings settings_;
  std::filesystem::path folder_;  ///< DIR/estimation
  std::unique_ptr<estimation::Estimator> estimator_;
  std::optional<json::LineWriter> log_;
  std::map<std::string, Batch> open_;  ///< by the name of their task
  int batches_ = 0;                    ///< so many were made; the next one's number
  int version_ = 0;                    ///< of the problem; 0: not begun
  double seconds_ = 0.0;               ///< of all evaluations
  int fruitless_ = 0;                  ///< batches one after the other that brought nothing
};

}  // namespace granary::estimating
