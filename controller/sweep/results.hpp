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

/// What others got at the same settings.
struct Reference {
  std::vector<std::string> values;  ///< of the settings but the seed, as in the cases
  std::vector<Figure> figures;
};

struct SweepResults {
  std::string name, description, solver;
  std::string host, version;
  std::vector<std::string> settings;  ///< names of the swept settings, shape (S)
  std::optional<std::size_t> seed;    ///< which of them only repeats a case
  std::vector<CaseResult> cases;
  std::vector<Reference> reference;  ///< of some of the settings; empty: there is none
};

/// Cases that differ only in their seed, or one that was not repeated.
struct Repeats {
  std::vector<std::string> values;  ///< of the settings but the seed
  std::vector<const CaseResult*> cases;
};
/// Of the cases that have any figure, in their order. The results must outlive it.
std::vector<Repeats> repeats_of(const SweepResults& results);
/// Names of the settings but the seed.
std::vector<std::string> conditions_of(const SweepResults& results);

/// Over repeats. scatter is the standard deviation with n - 1, NaN of less than two.
struct Spread {
  long n = 0;  ///< that have the figure
  double mean = std::numeric_limits<double>::quiet_NaN(), scatter = std::numeric_limits<double>::quiet_NaN();
};
Spread spread_of(const Repeats& repeats, const std::string& figure);
Spread spread_of(const std::vector<double>& values);

/// NaN if there is no such figure.
double figure_of(const std::vector<Figure>& figures, const std::string& name);
inline double figure_of(const CaseResult& one, const std::string& name) { return figure_of(one.figures, name); }
/// nullptr if the case has no such curve.
const Curve* curve_of(const CaseResult& one, const std::string& name);
/// Names of the figures that any case has, in the order they first come.
std::vector<std::string> figure_names(const SweepResults& results);

/// "d50_m" -> "m"; "1" where the name has no unit of ours.
std::string unit_of(const std::string& name);

/// A value of a setting as the table shows it: a text without its quotes; "" of null.
std::string text_of(const json::Value& value);
/// "300 rpm" -> 300; nothing if the text does not begin with a number.
std::optional<double> leading_number(const std::string& text);

json::Value to_json(const SweepResults& results);
/// One line a case: settings, state, wall_s, cpu_s, figures.
std::string to_csv(const SweepResults& results);
/// One line for cases that differ only in their seed: settings, how many, then mean and scatter of each figure.
std::string means_csv(const SweepResults& results);
/// results.h5, beside it first and then renamed over it.
Status write_h5(const SweepResults& results, const std::filesystem::path& file);

}  // namespace granary::sweep
