// One estimation from its first trial to its intervals: search, then differences about the best, then a sample of the
// posterior. Pure: no clock, no files, no processes; the same calls give the same trials. Who runs the trials, and
// remembers them, is controller/estimation.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estimation/problem/problem.hpp"
#include "estimation/search/search.hpp"

namespace granary::estimation {

struct Settings {
  Method method = Method::hybrid;
  std::uint64_t seed = 1;
  long most_evaluations = 5000;  ///< of one version of the problem
};

/// search: for the best fit; uncertainty: differences about it; posterior: a sample of what else fits; done: intervals
/// of 400 effective samples, or most_evaluations.
enum class Phase { search, uncertainty, posterior, done };
std::string name_of(Phase phase);

/// A trial that was run: what granary-pbm says of it.
struct Outcome {
  Residuals residuals;
  std::vector<double> held_out;  ///< residuals of the targets that are held out
  std::vector<double> model;     ///< values of all targets, SI
};

/// The best trial so far.
struct Fitted {
  std::vector<double> values;  ///< physical
  int version;                 ///< of the problem
  long trial;
  double cost;  ///< half the sum of squares
};

/// What is known so far. Everything in physical units, shape (parameters), unless said otherwise.
struct Estimate {
  int version = 0;                ///< of the problem
  long trial = -1;                ///< the best one; -1: none yet (then all that follows is empty)
  std::vector<double> values;     ///< of the best trial
  std::vector<double> low, high;  ///< 95 % intervals; empty until the differences are there
  bool from_posterior = false;    ///< the intervals are quantiles of the posterior's sample, not Laplace's
  double effective_samples = 0.0;
  std::vector<std::vector<double>> correlation;  ///< shape (parameters, parameters), on the parameters' scales
  std::vector<bool> at_bound;                    ///< the interval ends where the parameter's bounds do
  std::vector<std::string> unidentified;         ///< warnings, a sentence each: what the data cannot tell apart
  std::vector<std::string> doubts;               ///< likewise: data, held-out ones too, that are missed by too much
  std::string intervals;                         ///< what they are of, or why there are none yet: for people
  double cost = 0.0;                             ///< half the sum of squares
  double chi_square_per_datum = 0.0;             ///< sum of squares over (data - parameters)
  std::optional<double> held_out;                ///< mean square of the held-out residuals; about 1 if it predicts
  std::vector<double> model;                     ///< the targets' values at the best trial, SI
};
json::Value to_json(const Estimate& estimate, const std::vector<Parameter>& parameters);

class Estimator {
 public:
  Estimator(Problem problem, Settings settings, int version = 1);
  Estimator(Estimator&&) noexcept;
  Estimator& operator=(Estimator&&) noexcept;
  ~Estimator();

  /// What to run next; the numbers rise, over all versions. Never waits for results, but for the
  /// last ones: differences, which are to be about the best of all that is on its way. Empty then, and once
  /// most_evaluations have been asked for. When done it goes on sampling the posterior: the caller may stop asking.
  std::vector<Trial> ask(int count);
  /// nullopt: it failed, or was lost. Trials of an older version are counted as late and ignored.
  void tell(long trial, const std::optional<Outcome>& outcome);
  /// The same parameters, other experiments (new rates from the DEM) or targets. Begins again, but from what it knows:
  /// the best points are asked for first, and the search starts from the best of them.
  void change(Problem problem, int version);
  /// A trial of an earlier life at these physical values: known, but nobody waits for it. For replaying a log that
  /// another revision wrote.
  void inform(const std::vector<double>& values, const Outcome& outcome);

  const Problem& problem() const;
  int version() const;
  Phase phase() const;
  /// Physical values of a trial's point.
  std::vector<double> values_of(const Trial& trial) const;
  std::size_t waiting() const;         ///< asked for and not yet told of, of this version
  long asked() const;                  ///< of all versions
  long evaluated() const;              ///< told, of all versions, with a result
  long evaluated_now() const;          ///< of this version
  long failed() const;                 ///< told without a result
  long late() const;                   ///< told after a change()
  std::optional<Fitted> best() const;  ///< cheap
  Estimate estimate() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace granary::estimation
