#include "pbm_solver/bench/time_error.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "pbm_solver/bench/cost_front.hpp"
#include "pbm_solver/bench/reference_solver.hpp"
#include "pbm_solver/bench/solver_run.hpp"

namespace granary::pbm::bench {
namespace {

using json::Value;

constexpr double kWantedError = 1e-3;
constexpr std::array<double, 6> kTimeTolerances{1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};
constexpr std::array<double, 3> kEulerLimits{0.1, 0.05, 0.02};

Value rhs_for(const std::vector<CostPoint>& points, double error) {
  if (points.empty()) return {};
  const CostAtError found = cost_at_error(points, error);
  return found.reached ? Value(found.cost) : Value();
}

/// Before the stiff cases have come to rest: at rest every method would be right.
const std::vector<double> kInTransient{0.03, 0.1, 0.3, 1.0};

/// Largest difference at any of the looks, and at the end.
double largest_difference(const SolverRun& run, const SolverRun& exact) {
  double most = l1_difference(run.end.number, exact.end.number);
  for (std::size_t k = 0; k < exact.looks.size(); ++k)
    most = std::max(most, l1_difference(run.looks[k].number, exact.looks[k].number));
  return most;
}

/// One case at several tolerances. `make` gives it at a tolerance.
class TimeErrors {
 public:
  TimeErrors(const std::string& name, std::function<BenchCase(double)> make, std::vector<double> looks,
             double exact_tolerance, double most_cpu)
      : make_(std::move(make)), looks_(std::move(looks)), most_cpu_(most_cpu) {
    row_ = Value::object({{"case", name}, {"wanted_error", kWantedError}, {"exact_tolerance", exact_tolerance}});
    if (!looks_.empty()) row_.set("looks_s", looks_);
    exact_ = run(exact_tolerance);
    runs_ = Value::array();
  }

  void ours() {
    if (!exact_.finished) return;
    std::vector<CostPoint> points;
    for (const double tolerance : kTimeTolerances) {
      const auto ended = run_solver(make_(tolerance), most_cpu_, looks_);
      if (!ended || !ended->finished) {
        note("solver", tolerance, ended ? "over the time budget" : ended.error().message);
        continue;
      }
      const double error = largest_difference(*ended, exact_);
      points.push_back({double(ended->work.rhs_evaluations), error});
      runs_.push(Value::object({{"method", "solver"},
                                {"tolerance", tolerance},
                                {"rhs_evaluations", ended->work.rhs_evaluations},
                                {"steps", ended->work.steps},
                                {"rejected", ended->work.rejected},
                                {"l1_time_error", error}}));
    }
    row_.set("rhs_evaluations", rhs_for(points, kWantedError));
  }
  void reference() {
    if (!exact_.finished) return;
    std::vector<CostPoint> points;
    for (const double limit : kEulerLimits) {
      const BenchCase b = make_(1.0);
      ReferenceSolver solver(b.pbm_case);
      ReferenceState state = reference_state(b.start);
      const EulerRun run = run_euler(solver, state, b.pbm_case.end_time, limit, most_cpu_);
      if (!run.finished) {
        note("reference", limit, "over the time budget");
        continue;
      }
      const double error = l1_difference(state.number, exact_.end.number);
      points.push_back({double(run.steps), error});
      runs_.push(Value::object({{"method", "reference"},
                                {"tolerance", limit},
                                {"rhs_evaluations", run.steps},
                                {"steps", run.steps},
                                {"rejected", 0},
                                {"l1_time_error", error}}));
    }
    row_.set("reference_rhs_evaluations", rhs_for(points, kWantedError));
  }
  Value row() { return row_.set("runs", runs_); }

 private:
  void note(const char* method, double tolerance, const std::string& why) {
    runs_.push(Value::object({{"method", method}, {"tolerance", tolerance}, {"left_out", why}}));
  }
  SolverRun run(double tolerance) {
    auto ended = run_solver(make_(tolerance), most_cpu_, looks_);
    if (ended && ended->finished) return *std::move(ended);
    row_.set("left_out", ended ? "the run at exact_tolerance is over the time budget" : ended.error().message);
    return {};
  }

  std::function<BenchCase(double)> make_;
  std::vector<double> looks_;
  double most_cpu_;  ///< of a run [s]
  Value row_, runs_;
  SolverRun exact_;
};

}  // namespace

Value time_errors(Effort effort) {
  const double finest = by_effort(effort, 1e-7, 1e-9, 1e-9), most_cpu = by_effort(effort, 2.0, 30.0, 300.0);
  Value rows = Value::array();
  TimeErrors aggregation(
      "aggregation, 32 x 32", [](double tolerance) { return aggregation_case(32, tolerance); }, {}, finest, most_cpu);
  aggregation.ours();
  if (effort != Effort::quick) aggregation.reference();
  rows.push(aggregation.row());
  const auto stiff = [&](const char* name, double exponent, double largest) {
    TimeErrors errors(
        name, [=](double tolerance) { return stiff_case(exponent, largest, tolerance); }, kInTransient, finest,
        most_cpu);
    errors.ours();
    rows.push(errors.row());
  };
  stiff("aggregation and breakage k v, Smax T = 3.1e3", 1.0, 3.1e3);
  if (effort != Effort::quick) stiff("aggregation and breakage k v^2, Smax T = 2.4e4", 2.0, 2.4e4);
  return Value::object({{"temporal", rows}});
}

Value published_run(Effort effort) {
  constexpr double kUsual = 1e-3;
  const double most_cpu = by_effort(effort, 3.0, 60.0, 300.0);
  Value row = Value::object({{"grid", "16x16x16"}, {"end_s", 100.0}, {"tolerance", kUsual}, {"cores", 1}});
  const auto usual = run_solver(published_case(kUsual), most_cpu);
  if (!usual || !usual->finished)
    return Value::object(
        {{"published_case", row.set("left_out", usual ? "over the time budget" : usual.error().message)}});
  row.set("cpu_s", usual->cpu)
      .set("steps", usual->work.steps)
      .set("rejected", usual->work.rejected)
      .set("rhs_evaluations", usual->work.rhs_evaluations);
  const auto fine = run_solver(published_case(kUsual / 100.0), most_cpu);
  if (fine && fine->finished) {
    row.set("l1_time_error", l1_difference(usual->end.number, fine->end.number))
        .set("time_error_against_tolerance", kUsual / 100.0);
  } else {
    row.set("l1_time_error", Value()).set("left_out", "the run at a hundredth of the tolerance");
  }
  return Value::object({{"published_case", row}});
}

}  // namespace granary::pbm::bench
