#include "pbm_solver/verification/verification.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <iterator>
#include <limits>

#include "common/json/problems.hpp"
#include "pbm_solver/time/simulation.hpp"

namespace granary::pbm {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kLeastNumber = -1e-13;
constexpr double kToleranceOfBounds = 1e-5, kTimeErrors = 2.0;

Result<VerificationCase> find_case(const std::string& name) {
  const std::vector<VerificationCase> all = verification_cases();
  const auto found = std::find_if(all.begin(), all.end(), [&](const VerificationCase& v) { return v.name == name; });
  if (found != all.end()) return *found;
  const std::string near = json::did_you_mean(name, verification_names());
  return Error{fmt::format("verify: there is no case \"{}\"; there are {}.{}", name,
                           fmt::join(verification_names(), ", "),
                           near.empty() ? "" : " Did you mean \"" + near + "\"?")};
}

double named(const NamedErrors& list, const std::string& name) {
  const auto found = std::find_if(list.begin(), list.end(), [&](const auto& one) { return one.first == name; });
  return found == list.end() ? kNone : found->second;
}

/// The bounds that hold on this grid, wider by twice the tolerance where it is looser than usual; on other grids than
/// the table's there are none but of what is conserved.
void set_bounds(const VerificationCase& known, Verification& v) {
  v.l1_bound = kNone;
  v.drift_bound = known.pbm_case(v.bins).breakage ? kDriftImplicit : kDriftExplicit;  // breakage may be implicit
  const auto grid =
      std::find_if(known.grids.begin(), known.grids.end(), [&](const Bound& b) { return b.bins == v.bins; });
  if (grid == known.grids.end()) return;
  const double wider = kTimeErrors * std::max(0.0, v.tolerance - kToleranceOfBounds);
  if (!std::isnan(v.errors.l1_number)) v.l1_bound = grid->l1_number + wider;
  v.moment_bounds = known.bounds;
  for (const auto& [name, bound] : grid->moments) {
    std::erase_if(v.moment_bounds, [&, &n = name](const auto& one) { return one.first == n; });
    v.moment_bounds.emplace_back(name, bound);
  }
  std::erase_if(v.moment_bounds, [&](const auto& one) { return std::isnan(v.moment(one.first)); });
  for (auto& one : v.moment_bounds) one.second += wider;
}

/// Error whose decrease from grid to grid is the order.
double error_for_order(const VerificationCase& known, const Verification& v) {
  if (known.order_of.empty()) return kNone;
  return known.order_of == "L1" ? v.errors.l1_number : std::abs(v.moment(known.order_of));
}

Result<Verification> verify_on(const VerificationCase& known, int bins, double relative_tolerance) {
  if (bins < 2 || bins > 256) return Error{fmt::format("verify: --bins is {}; it must be in [2, 256].", bins)};
  PbmCase c = known.pbm_case(bins);
  c.relative_tolerance = relative_tolerance;
  Alone alone(c.compartments.count);
  const Snapshot start = initial_snapshot(c, ClassGrid(c.grid));
  const std::clock_t began = std::clock();
  Simulation simulation(c, start, alone, 1);
  GRANARY_TRY(const bool reached, simulation.advance(c.end_time));
  static_cast<void>(reached);
  const Snapshot end = simulation.snapshot();

  Verification v;
  v.cpu = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
  v.name = known.name, v.group = known.group, v.text = known.text, v.reason = known.reason;
  v.bins = bins, v.tolerance = relative_tolerance;
  v.errors = known.compare(c, simulation.grid(), end);
  v.order = kNone;
  v.drift = drift(end, simulation.grid());
  double all = 0.0;
  for (const double number : end.number) all += number;
  v.least_number = *std::min_element(end.number.begin(), end.number.end()) / all;
  v.steps = simulation.work().steps, v.rejected = simulation.work().rejected;
  v.rhs_evaluations = simulation.work().rhs_evaluations;
  set_bounds(known, v);
  v.passed = v.faults().empty();
  return v;
}

}  // namespace

json::Value to_json(const NamedErrors& errors) {
  json::Value object = json::Value::object({});
  for (const auto& [name, value] : errors) object.set(name, value);
  return object;
}

double Verification::largest_drift() const { return std::max({drift.solid_1, drift.solid_2, drift.liquid, drift.gas}); }

double Verification::moment(const std::string& moment_name) const { return named(errors.moments, moment_name); }

double Verification::moment_bound(const std::string& moment_name) const { return named(moment_bounds, moment_name); }

std::vector<std::string> Verification::faults() const {
  std::vector<std::string> list;
  // Written so that a NaN is beyond every bound.
  if (!std::isnan(l1_bound) && !(errors.l1_number <= l1_bound))
    list.push_back(fmt::format("L1 of the number is {:.4g}, its bound {:.4g}", errors.l1_number, l1_bound));
  for (const auto& [moment_name, bound] : moment_bounds)
    if (!(std::abs(moment(moment_name)) <= bound))
      list.push_back(
          fmt::format("the error of {} is {:.3g}, its bound {:.3g}", moment_name, moment(moment_name), bound));
  if (!(largest_drift() <= drift_bound))
    list.push_back(fmt::format("the balance drifts by {:.2g}, its bound {:.2g}", largest_drift(), drift_bound));
  if (!(least_number >= kLeastNumber))
    list.push_back(fmt::format("a class holds {:.2g} of all particles; less than none", least_number));
  return list;
}

std::vector<VerificationCase> verification_cases() {
  std::vector<VerificationCase> all;
  for (auto* part : {aggregation_cases, aggregation_2d_cases, breakage_cases, transport_cases}) {
    std::vector<VerificationCase> some = part();
    std::move(some.begin(), some.end(), std::back_inserter(all));
  }
  return all;
}

std::vector<std::string> verification_names() {
  std::vector<std::string> names;
  for (const VerificationCase& v : verification_cases()) names.push_back(v.name);
  return names;
}

Result<Verification> verify(const std::string& name, int bins, double relative_tolerance) {
  GRANARY_TRY(const VerificationCase known, find_case(name));
  return verify_on(known, bins, relative_tolerance);
}

Result<std::vector<Verification>> verify_grids(const std::string& name, std::optional<int> bins,
                                               double relative_tolerance) {
  GRANARY_TRY(const VerificationCase known, find_case(name));
  std::vector<int> grids;
  for (const Bound& grid : known.grids) grids.push_back(grid.bins);
  if (bins) grids = {*bins};
  std::vector<Verification> list;
  for (const int n : grids) {
    GRANARY_TRY(Verification v, verify_on(known, n, relative_tolerance));
    if (!list.empty())
      v.order = std::log(error_for_order(known, list.back()) / error_for_order(known, v)) /
                std::log(static_cast<double>(n) / list.back().bins);
    list.push_back(std::move(v));
  }
  return list;
}

json::Value to_json(const Verification& v) {
  return json::Value::object({{"name", v.name},
                              {"group", v.group},
                              {"text", v.text},
                              {"bins", v.bins},
                              {"tolerance", v.tolerance},
                              {"l1_number", v.errors.l1_number},
                              {"l1_number_bound", v.l1_bound},
                              {"l1_volume", v.errors.l1_volume},
                              {"moment_errors", to_json(v.errors.moments)},
                              {"moment_bounds", to_json(v.moment_bounds)},
                              {"bound_reason", v.reason},
                              {"order", v.order},
                              {"drift", json::Value::object({{"solid_1", v.drift.solid_1},
                                                             {"solid_2", v.drift.solid_2},
                                                             {"liquid", v.drift.liquid},
                                                             {"gas", v.drift.gas}})},
                              {"drift_bound", v.drift_bound},
                              {"least_number", v.least_number},
                              {"steps", v.steps},
                              {"rejected", v.rejected},
                              {"rhs_evaluations", v.rhs_evaluations},
                              {"cpu_s", v.cpu},
                              {"passed", v.passed}});
}

}  // namespace granary::pbm
