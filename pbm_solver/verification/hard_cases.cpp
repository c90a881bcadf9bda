#include "pbm_solver/verification/hard_cases.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>

#include "common/json/io.hpp"
#include "common/json/problems.hpp"
#include "pbm_solver/time/simulation.hpp"

namespace granary::pbm {
namespace {

using json::Value;

#ifdef NDEBUG
constexpr double kMostCpu = 10.0;  // [s] of a run
#else
constexpr double kMostCpu = 200.0;  // with asserts and sanitizers
#endif
constexpr double kLeast = -1e-13;  // round-off

double cpu_now() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double least_of(const std::vector<double>& field) {
  double least = 0.0, all = 0.0;
  for (const double value : field) least = std::min(least, value), all += std::abs(value);
  return least == 0.0 ? 0.0 : least / all;
}

struct Ended {
  Snapshot state;
  WorkCount work;
  double least = 0.0;
  bool timed_out = false;
};

void add(const WorkCount& some, WorkCount& all) {
  all.steps += some.steps, all.implicit_steps += some.implicit_steps;
  all.rejected += some.rejected, all.rhs_evaluations += some.rhs_evaluations;
}

/// From `start` to `end`, by outputs.
Result<Ended> run(const PbmCase& c, const Snapshot& start, double end) {
  Alone alone(c.compartments.count);
  Simulation simulation(c, start, alone, 1);
  const double began = cpu_now();
  Ended ended;
  for (double next = start.time; next < end && !ended.timed_out;) {
    next = std::min(end, next + c.output_every);
    GRANARY_TRY(const bool reached, simulation.advance(next, [&] { return cpu_now() - began < kMostCpu; }));
    ended.timed_out = !reached;
    ended.state = simulation.snapshot();
    for (const auto* field : {&ended.state.number, &ended.state.liquid, &ended.state.gas})
      ended.least = std::min(ended.least, least_of(*field));
  }
  ended.work = simulation.work();
  return ended;
}

Result<Ended> run_whole(const HardCase& known, PbmCase c, double tolerance) {
  c.relative_tolerance = tolerance;
  const Snapshot start = initial_snapshot(c, ClassGrid(c.grid));
  if (!known.change) return run(c, start, c.end_time);
  GRANARY_TRY(const Ended first, run(c, start, 0.5 * c.end_time));
  known.change(c);
  GRANARY_TRY(Ended second, run(c, first.state, c.end_time));
  add(first.work, second.work);
  second.least = std::min(second.least, first.least);
  second.timed_out = second.timed_out || first.timed_out;
  return second;
}

double l1(const std::vector<double>& a, const std::vector<double>& b) {
  double off = 0.0, all = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) off += std::abs(a[k] - b[k]), all += std::abs(b[k]);
  return off / all;
}

double largest(const Drift& d) { return std::max({d.solid_1, d.solid_2, d.liquid, d.gas}); }

std::string in_short(const HardResult& r) {
  if (r.refusal) return "refused";
  if (!std::isnan(r.l1_number)) return fmt::format("L1 {:.1e}", r.l1_number);
  return r.errors.empty() ? "-" : fmt::format("{} {:+.1e}", r.errors.back().first, r.errors.back().second);
}

std::string bound_in_short(const HardResult& r) {
  if (r.known.must_refuse) return "refusal";
  if (!std::isnan(r.l1_number)) return fmt::format("{:.0e}", r.known.l1_bound);
  for (const auto& [name, bound] : r.known.bounds)
    if (!r.errors.empty() && name == r.errors.back().first) return fmt::format("{:.0e}", bound);
  return "-";
}

constexpr const char* kHardRow = "{:<24}{:>5}  {:<22}{:>8}{:>9}{:>7}{:>7}{:>8}{:>8}  {:<4}{}\n";

}  // namespace

std::vector<std::string> HardResult::faults() const {
  std::vector<std::string> list;
  if (timed_out) list.push_back(fmt::format("it took more than {:g} s", kMostCpu));
  if (known.must_refuse && !refusal) list.emplace_back("it should have been refused");
  if (refusal && !(known.must_refuse && refusal->exit == kToleranceNotKept)) list.push_back(refusal->message);
  if (refusal || timed_out) return list;
  // Written so that a NaN is beyond every bound.
  if (known.fine_tolerance > 0.0 && !(l1_number <= known.l1_bound))
    list.push_back(fmt::format("L1 of the number is {:.3g}, its bound {:.3g}", l1_number, known.l1_bound));
  for (const auto& [name, bound] : known.bounds) {
    const auto error =
        std::find_if(errors.begin(), errors.end(), [&, &n = name](const auto& e) { return e.first == n; });
    if (error == errors.end() || !(std::abs(error->second) <= bound))
      list.push_back(fmt::format("the error of {} is {:.3g}, its bound {:.3g}", name,
                                 error == errors.end() ? std::nan("") : error->second, bound));
  }
  if (!(largest(drift) <= drift_bound))
    list.push_back(fmt::format("the balance drifts by {:.2g}, its bound {:.2g}", largest(drift), drift_bound));
  if (!(least >= kLeast)) list.push_back(fmt::format("a class holds {:.2g} of what all hold; less than none", least));
  return list;
}

HardResult run_hard_case(const HardCase& known) {
  HardResult result;
  result.known = known;
  const PbmCase c = known.pbm_case();
  const ClassGrid grid(c.grid);
  result.bins = c.grid.bins[0];
  result.l1_number = std::numeric_limits<double>::quiet_NaN();
  const double began = cpu_now();
  const auto ended = run_whole(known, c, c.relative_tolerance);
  result.cpu = cpu_now() - began;
  if (!ended) {
    result.refusal = ended.error();
    return result;
  }
  result.steps = ended->work.steps, result.implicit_steps = ended->work.implicit_steps;
  result.rhs_evaluations = ended->work.rhs_evaluations;
  result.least = ended->least, result.timed_out = ended->timed_out;
  result.drift = drift(ended->state, grid);
  result.drift_bound = result.implicit_steps > 0 ? kDriftImplicit : kDriftExplicit;
  if (known.compare) result.errors = known.compare(c, grid, ended->state);
  if (known.fine_tolerance > 0.0) {
    const auto fine = run_whole(known, c, known.fine_tolerance);
    if (fine && !fine->timed_out) result.l1_number = l1(ended->state.number, fine->state.number);
  }
  return result;
}

Value to_json(const HardResult& r) {
  Value document = Value::object({{"name", r.known.name},
                                  {"text", r.known.text},
                                  {"bins", r.bins},
                                  {"l1_number", r.l1_number},
                                  {"l1_number_bound", r.known.l1_bound},
                                  {"moment_errors", to_json(r.errors)},
                                  {"moment_bounds", to_json(r.known.bounds)},
                                  {"bound_reason", r.known.reason},
                                  {"order", std::nan("")},
                                  {"drift", Value::object({{"solid_1", r.drift.solid_1},
                                                           {"solid_2", r.drift.solid_2},
                                                           {"liquid", r.drift.liquid},
                                                           {"gas", r.drift.gas}})},
                                  {"drift_bound", r.drift_bound},
                                  {"least_value", r.least},
                                  {"steps", r.steps},
                                  {"implicit_steps", r.implicit_steps},
                                  {"rhs_evaluations", r.rhs_evaluations},
                                  {"cpu_s", r.cpu},
                                  {"passed", r.faults().empty()}});
  if (r.refusal) document.set("refusal", r.refusal->message);
  return document;
}

int verify_hard(const std::string& name, bool as_json) {
  bool passed = true, any = false;
  Value cases = Value::array();
  if (!as_json)
    fmt::print(kHardRow, "hard case", "bins", "error", "bound", "least", "drift", "steps", "impl.", "rhs", "ok",
               "cpu s");
  for (const HardCase& known : hard_cases()) {
    if (!name.empty() && known.name != name) continue;
    any = true;
    const HardResult r = run_hard_case(known);
    const std::vector<std::string> faults = r.faults();
    passed = passed && faults.empty();
    cases.push(to_json(r));
    if (as_json) continue;
    fmt::print(kHardRow, known.name, r.bins, in_short(r), bound_in_short(r), fmt::format("{:.0e}", r.least),
               fmt::format("{:.0e}", largest(r.drift)), r.steps, r.implicit_steps, r.rhs_evaluations,
               faults.empty() ? "yes" : "NO", fmt::format("{:.3f}", r.cpu));
    for (const std::string& fault : faults) fmt::print("    {}\n", fault);
    std::fflush(stdout);
  }
  if (!any) {
    std::vector<std::string> names;
    for (const HardCase& known : hard_cases()) names.push_back(known.name);
    fmt::print(stderr, "granary-pbm: verify hard: there is no case \"{}\"; there are {}.\n", name,
               fmt::join(names, ", "));
    return static_cast<int>(Exit::bad_input);
  }
  if (as_json) std::printf("%s\n", json::dump(Value::object({{"cases", cases}}), 2).c_str());
  return static_cast<int>(passed ? Exit::ok : Exit::task_failed);
}

}  // namespace granary::pbm
