#include "pbm_solver/verification/verification.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <map>

#include "common/json/problems.hpp"
#include "pbm_solver/output/summary.hpp"
#include "pbm_solver/time/simulation.hpp"
#include "pbm_solver/verification/exact_solutions.hpp"

namespace granary::pbm {
namespace {

/// A case with an exact solution: unit start, unit rates.
struct Setting {
  std::string name, text;
  bool two_solids;
  double smallest, largest;  ///< first and last edge of the cells
  double end;
  int bins;  ///< unless asked otherwise
  std::optional<Aggregation> aggregation;
  std::optional<Breakage> breakage;
  std::function<double(double x, double y, double t)> density;
  std::function<double(double t)> moment_0, moment_2;
  std::map<int, double> best_known;
};

Aggregation aggregation_with(Aggregation::Kernel kernel) {
  Aggregation a;
  a.kernel = kernel;
  return a;
}

Breakage linear_breakage() {
  Breakage b;
  b.selection = Breakage::Selection::linear;
  return b;
}

std::vector<Setting> settings() {
  using K = Aggregation::Kernel;
  return {
      {"constant-1d",
       "aggregation, constant kernel, exponential start, t = 100",
       false,
       1e-6,
       1e5,
       100.0,
       73,
       aggregation_with(K::constant),
       {},
       [](double x, double, double t) { return exact::constant_kernel(x, t); },
       [](double t) { return 2.0 / (2.0 + t); },
       [](double t) { return 2.0 + t; },
       {{37, 0.050}, {73, 0.015}, {110, 0.0073}}},
      {"sum-1d",
       "aggregation, sum kernel (Golovin), exponential start, t = 3",
       false,
       1e-6,
       1e6,
       3.0,
       80,
       aggregation_with(K::sum),
       {},
       [](double x, double, double t) { return exact::sum_kernel(x, t); },
       [](double t) { return std::exp(-t); },
       [](double t) { return 2.0 * std::exp(2.0 * t); },
       {{40, 0.026}, {80, 0.0066}, {120, 0.0031}}},
      {"constant-2d",
       "two solids, constant kernel, exponential start, t = 8",
       true,
       std::ldexp(1.0, -9),
       std::ldexp(1.0, 7),
       8.0,
       32,
       aggregation_with(K::constant),
       {},
       exact::constant_kernel_2d,
       [](double t) { return 2.0 / (2.0 + t); },
       [](double t) { return 2.0 + t; },
       {{16, 0.125}, {32, 0.035}, {64, 0.012}}},
      {"sum-2d",
       "two solids, sum kernel, exponential start, t = 0.5",
       true,
       1e-3,
       1e3,
       0.5,
       24,
       aggregation_with(K::sum),
       {},
       exact::sum_kernel_2d,
       [](double t) { return std::exp(-2.0 * t); },
       [](double t) { return 0.5 + 1.5 * std::exp(4.0 * t); },
       {{16, 0.137}, {24, 0.085}, {32, 0.046}, {48, 0.023}}},
      {"breakage",
       "uniform binary breakage at the rate v, exponential start, t = 4",
       false,
       1e-2,
       1e2,
       4.0,
       48,
       {},
       linear_breakage(),
       [](double x, double, double t) { return exact::linear_breakage(x, t); },
       [](double t) { return 1.0 + t; },
       [](double t) { return 2.0 / (1.0 + t); },
       {{24, 0.145}, {48, 0.039}, {96, 0.0086}, {192, 0.0020}}},
  };
}

PbmCase case_of(const Setting& s, int bins, double relative_tolerance) {
  PbmCase c;
  c.name = s.name;
  const double ratio = std::pow(s.largest / s.smallest, 1.0 / bins);
  const double first = 0.5 * (1.0 + ratio) * s.smallest;
  c.grid = {{bins, s.two_solids ? bins : 1}, {first, s.two_solids ? first : 0.0}, {ratio, s.two_solids ? ratio : 2.0}};
  c.compartments.volume = {1.0};
  c.aggregation = s.aggregation;
  c.breakage = s.breakage;
  c.end_time = c.output_every = s.end;
  c.relative_tolerance = relative_tolerance;
  return c;
}

Snapshot start_of(const Setting& s, const PbmCase& c, const ClassGrid& grid) {
  PbmCase filled = c;
  const auto start = exact::cell_content(grid, [&](double x, double y) { return s.density(x, y, 0.0); });
  const std::vector<double> number = exact::at_pivots(grid, start);
  for (int i = 0; i < grid.axis(0).size(); ++i)
    for (int j = 0; j < grid.axis(1).size(); ++j)
      if (number[grid.index(i, j)] > 0.0) filled.initial.push_back({0, i, j, number[grid.index(i, j)], 0.0, 0.0});
  return initial_snapshot(filled, grid);
}

void compare(const Setting& s, const ClassGrid& grid, const Snapshot& end, Verification& v) {
  const BirthGrid exact = exact::cell_content(grid, [&](double x, double y) { return s.density(x, y, s.end); });
  double off_number = 0.0, off_volume = 0.0, all_number = 0.0, all_volume = 0.0, m0 = 0.0, m1 = 0.0, m2 = 0.0;
  for (int i = 0; i < grid.axis(0).size(); ++i)
    for (int j = 0; j < grid.axis(1).size(); ++j) {
      const std::size_t k = grid.index(i, j);
      const Birth& cell = exact.at(i, j);
      const double x = grid.solid_1()[k], number = end.number[k];
      off_number += std::abs(number - cell.number);
      all_number += cell.number;
      off_volume += std::abs(number * grid.solid()[k] - cell.solid_1 - cell.solid_2);
      all_volume += cell.solid_1 + cell.solid_2;
      m0 += number, m1 += x * number, m2 += x * x * number;
    }
  v.l1_number = off_number / all_number;
  v.l1_volume = off_volume / all_volume;
  v.moment_0 = m0 / s.moment_0(s.end) - 1.0;
  v.moment_1 = m1 - 1.0;
  v.moment_2 = m2 / s.moment_2(s.end) - 1.0;
  v.least_number = *std::min_element(end.number.begin(), end.number.end());
  const Drift d = drift(end, grid);
  v.drift = std::max(d.solid_1, d.solid_2);
}

}  // namespace

std::vector<std::string> verification_names() {
  std::vector<std::string> names;
  for (const Setting& s : settings()) names.push_back(s.name);
  return names;
}

Result<Verification> verify(const std::string& name, std::optional<int> bins, double relative_tolerance) {
  const std::vector<Setting> all = settings();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Setting& s) { return s.name == name; });
  if (found == all.end()) {
    const std::string near = json::did_you_mean(name, verification_names());
    return Error{fmt::format("verify: there is no case \"{}\"; there are {}.{}", name,
                             fmt::join(verification_names(), ", "),
                             near.empty() ? "" : " Did you mean \"" + near + "\"?")};
  }
  const Setting& s = *found;
  Verification v;
  v.name = s.name;
  v.text = s.text;
  v.bins = bins.value_or(s.bins);
  if (v.bins < 2 || v.bins > 256) return Error{fmt::format("verify: --bins is {}; it must be in [2, 256].", v.bins)};
  if (const auto known = s.best_known.find(v.bins); known != s.best_known.end()) v.best_known = known->second;

  const PbmCase c = case_of(s, v.bins, relative_tolerance);
  Alone alone(1);
  const Snapshot start = start_of(s, c, ClassGrid(c.grid));
  const std::clock_t began = std::clock();
  Simulation simulation(c, start, alone, 1);
  GRANARY_TRY(const bool reached, simulation.advance(s.end));
  static_cast<void>(reached);
  v.cpu = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
  v.steps = simulation.work().steps;
  v.rhs_evaluations = simulation.work().rhs_evaluations;
  compare(s, simulation.grid(), simulation.snapshot(), v);
  return v;
}

json::Value to_json(const Verification& v) {
  json::Value document = json::Value::object({{"case", v.name},
                                              {"text", v.text},
                                              {"bins", v.bins},
                                              {"l1_number", v.l1_number},
                                              {"l1_volume", v.l1_volume},
                                              {"moment_0", v.moment_0},
                                              {"moment_1", v.moment_1},
                                              {"moment_2", v.moment_2},
                                              {"drift", v.drift},
                                              {"least_number", v.least_number},
                                              {"steps", static_cast<std::int64_t>(v.steps)},
                                              {"rhs_evaluations", static_cast<std::int64_t>(v.rhs_evaluations)},
                                              {"cpu_s", v.cpu}});
  if (v.best_known) document.set("best_known_l1_number", *v.best_known);
  return document;
}

}  // namespace granary::pbm
