// What a sweep came to: a table of its cases, and the course of each over time. Plain data, and its files.
// Names, shapes and units for readers of the files: docs/results_format.md#results-of-a-sweep.
#pragma once

#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::sweep {

struct Figure {
  std::string name;  ///< "d50_m": with its unit behind the last underscore, as in the solvers' files
  double value = std::numeric_limits<double>::quiet_NaN();
};

/// A figure over time.
struct Curve {
  std::string name;
  std::vector<double> time;   ///< [s], shape (T)
  std::vector<double> value;  ///< shape (T); NaN where it is not known
};

struct CaseResult {
  std::string name;                 ///< "0001"
  std::vector<std::string> values;  ///< of the swept settings, as written; "" as in the workflow; shape (S)
  std::string state;                ///< finished | failed | stopped | unfinished | waiting: of its task
  double wall = 0.0;                ///< [s]
  double cpu = 0.0;                 ///< [s]
  std::vector<Figure> figures;      ///< at its end
  std::vector<Curve> curves;
};

struct SweepResults {
  std::string name, description, solver;
  std::string host, version;
  std::vector<std::string> settings;  ///< names of the swept settings, shape (S)
  std::vector<CaseResult> cases;
};

/// NaN if the case has no such figure.
double figure_of(const CaseResult& one, const std::string& name);
/// nullptr if the case has no such curve.
const Curve* curve_of(const CaseResult& one, const std::string& name);
/// Names of the figures that any case has, in the order they first come.
std::vector<std::string> figure_names(const SweepResults& results);

/// A value of a setting as the table shows it: a text without its quotes; "" of null.
std::string text_of(const json::Value& value);
/// "300 rpm" -> 300; nothing if the text does not begin with a number.
std::optional<double> leading_number(const std::string& text);

json::Value to_json(const SweepResults& results);
/// One line a case: settings, state, wall_s, cpu_s, figures.
std::string to_csv(const SweepResults& results);
/// results.h5, beside it first and then renamed over it.
Status write_h5(const SweepResults& results, const std::filesystem::path& file);

}  // namespace granary::sweep
