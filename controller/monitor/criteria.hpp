// When a watched burst should end: pure, a series of watched properties -> a verdict. Which properties those are:
// watched.hpp. The rules, with their reasons: docs/coupling.md#when-a-burst-ends.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "controller/monitor/verdict.hpp"

namespace granary::monitor {

struct Options {
  double threshold = 0.15;           ///< relative change that is a drift; the bound of steady [-]
  double grace = 0.2;                ///< from the burst's start, not looked at [s]
  double steady_window = 5.0;        ///< [s]; 0: never say steady
  double converged_tolerance = 0.0;  ///< relative standard error [-]; 0: never say converged
  double significance = 3.0;         ///< a change is one only beyond this many of its standard errors
  int average = 3;                   ///< rows that make one value (DEM 3, PBM 1)
  bool watch_drift = true;           ///< false: never say drifted
};

struct Property {
  std::string name;         ///< with its unit, as in the file: "d50_m"
  std::string where;        ///< "compartment 2", "all"
  bool independent = true;  ///< the errors of two rows are independent, so a mean over rows is surer (counts)
};

/// A property in one row.
struct Sample {
  double value = 0.0;  ///< NaN: too little of it to watch
  double error = 0.0;  ///< standard error by counting; 0: exact
  double floor = 0.0;  ///< least denominator of a relative change: what is smaller is not worth a switch
};

struct Row {
  double begin = 0.0, end = 0.0;  ///< what it covers [s]; PBM: equal
  std::vector<Sample> samples;    ///< shape (properties)
};

/// Judges row by row, so the verdict depends on the rows alone and not on how they were read.
class Criteria {
 public:
  Criteria(Options options, std::vector<Property> properties);

  /// The first outcome other than `none` is final; order where several hold: drifted, steady, converged.
  ///
  ///   drifted    |mean of the last `average` rows - mean of the first `average` rows after the grace time|
  ///              > threshold * reference, and beyond its noise, for any property; both signs
  ///   steady     (max - min) of the running means over the steady window <= threshold * mean, or within its noise,
  ///              for every property; at least one property must be sure enough to have shown a move of the threshold
  ///   converged  standard error of the mean over all rows after the grace time <= tolerance * mean for every property;
  ///              the larger of the counting error and the scatter of ten batch means, widened by their correlation
  ///
  /// Noise is sqrt(significance^2 + 2 ln looks) standard errors of the difference by counting statistics, looks being
  /// the rows compared so far: someone who looks a thousand times must not be surprised by 3 sigma.
  Verdict add(Row row);

  /// What there is to say when no more rows will come: `ended`.
  Verdict ended() const;
  double burst_start() const { return rows_.empty() ? 0.0 : rows_.front().begin; }

 private:
  struct Mean;
  Mean mean(std::size_t property, std::size_t first, std::size_t count) const;
  double errors_allowed(std::size_t looks) const;
  Verdict drifted() const;
  Verdict steady() const;
  Verdict converged() const;
  Verdict verdict(Outcome outcome, const Property* property) const;

  Options options_;
  std::vector<Property> properties_;
  std::vector<Row> rows_;
  std::size_t first_ = 0;  ///< first row that begins after the grace time
};

}  // namespace granary::monitor
