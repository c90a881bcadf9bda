// An estimation as data: which numbers of which population balances are to fit which measurements. Its file form,
// problem.json, is what granary-pbm evaluate reads (docs/exchange_formats.md). Knows no solver.
#pragma once

#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "estimation/problem/parameter.hpp"
#include "estimation/problem/target.hpp"

namespace granary::estimation {

/// One process that was measured. Its segments are cases of granary-pbm (docs/exchange_formats.md), run one after the
/// other, each from the state in which the one before it ended (the start of a later one is not looked at) to its own
/// end_time; the last goes on to the experiment's last target.
struct Experiment {
  std::string name;
  std::vector<json::Value> segments;  ///< at least one
};

struct Problem {
  std::vector<Parameter> parameters;  ///< at least one
  std::vector<Experiment> experiments;
  std::vector<Target> targets;
};

/// From a parsed problem.json; every problem at once: a pointer at which a segment has no number, a target of an
/// experiment that does not exist, bounds the wrong way round. The segments themselves are read by granary-pbm.
Result<Problem> read_problem(const json::Value& document, const std::string& file);
json::Value to_json(const Problem& problem);

/// Where a search begins: the parameters' own starts; in the unit cube, shape (parameters).
std::vector<double> start_of(const Problem& problem);

/// How a trial fits: (model - data) / error sqrt(weight) of all targets that are fitted, in their order (of a
/// distribution: of each share), then (parameter - mean) / deviation of every prior.
/// @param model   the targets' values by the model, SI, in order, held-out ones too, shape (sum of the targets' sizes)
/// @param values  of the parameters
struct Fit {
  std::vector<double> residuals;
  std::vector<double> held_out;  ///< likewise, of the targets that are held out
};
Fit fit_of(const Problem& problem, const std::vector<double>& model, const std::vector<double>& values);

}  // namespace granary::estimation
