#include "pbm_solver/bench/work_precision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pbm_solver/bench/cost_front.hpp"
#include "pbm_solver/bench/reference_solver.hpp"
#include "pbm_solver/bench/solver_run.hpp"
#include "pbm_solver/verification/exact_solutions.hpp"

namespace granary::pbm::bench {
namespace {

using json::Value;

constexpr std::array<double, 5> kTolerances{1e-1, 1e-2, 1e-3, 1e-4, 1e-5};
constexpr std::array<double, 4> kErrors{0.12, 0.05, 0.037, 0.013};

/// Numbers that the exact solution holds in each cell at the end of the case.
std::vector<double> exact_numbers(const PbmCase& c) {
  const ClassGrid grid(c.grid);
  const BirthGrid cells =
      exact::cell_content(grid, [&c](double x, double y) { return exact::constant_kernel_2d(x, y, c.end_time); });
  std::vector<double> numbers;
  for (int i = 0; i < grid.axis(0).size(); ++i)
    for (int j = 0; j < grid.axis(1).size(); ++j) numbers.push_back(cells.at(i, j).number);
  return numbers;
}

/// The runs of one method, and what it has left to spend.
class Method {
 public:
  Method(std::string name, double budget) : name_(std::move(name)), left_(budget) {}

  double left() const { return left_; }
  /// Whether a run of the reference fits in: its time goes as bins^4 / limit, from the run before.
  bool affords(int bins, double limit) const { return per_unit_ * units(bins, limit) <= left_; }
  void ran(int bins, double tolerance, double cpu, double error, std::int64_t rhs) {
    left_ -= cpu;
    per_unit_ = cpu / units(bins, tolerance);
    points_.push_back({cpu, error});
    rows_.push_back(Value::object({{"method", name_},
                                   {"bins", bins},
                                   {"tolerance", tolerance},
                                   {"cpu_s", cpu},
                                   {"l1_number", error},
                                   {"rhs_evaluations", rhs}}));
  }
  void left_out(int bins, double tolerance, const std::string& why, double spent) {
    left_ -= spent;
    left_out_.push_back(Value::object({{"method", name_}, {"bins", bins}, {"tolerance", tolerance}, {"why", why}}));
  }

  const std::vector<CostPoint>& points() const { return points_; }
  const std::vector<Value>& rows() const { return rows_; }
  const std::vector<Value>& all_left_out() const { return left_out_; }

 private:
  static double units(int bins, double limit) { return std::pow(double(bins), 4) / limit; }
  std::string name_;
  double left_;            ///< [s] of CPU time
  double per_unit_ = 0.0;  ///< time of the last run over bins^4 / limit [s]
  std::vector<CostPoint> points_;
  std::vector<Value> rows_, left_out_;
};

void run_ours(Method& ours, const std::vector<int>& all_bins) {
  for (const int bins : all_bins) {
    BenchCase b = aggregation_case(bins, 1.0);
    const std::vector<double> exact = exact_numbers(b.pbm_case);
    for (const double tolerance : kTolerances) {
      b.pbm_case.relative_tolerance = tolerance;
      const double budget = ours.left();
      const auto run = budget > 0.0 ? run_solver(b, budget) : Result<SolverRun>(SolverRun{});
      if (!run) {
        ours.left_out(bins, tolerance, run.error().message, 0.0);
      } else if (!run->finished) {
        ours.left_out(bins, tolerance, "over the time budget", run->cpu);
      } else {
        ours.ran(bins, tolerance, run->cpu, l1_difference(run->end.number, exact), run->work.rhs_evaluations);
      }
    }
  }
}

void run_reference(Method& reference, const std::vector<int>& all_bins, const std::vector<double>& limits) {
  for (const int bins : all_bins) {
    const BenchCase b = aggregation_case(bins, 1.0);
    const std::vector<double> exact = exact_numbers(b.pbm_case);
    for (const double limit : limits) {
      if (!reference.affords(bins, limit)) {
        reference.left_out(bins, limit, fmt::format("would not fit into the {:.3g} s left for it", reference.left()),
                           0.0);
        continue;
      }
      ReferenceSolver solver(b.pbm_case);
      ReferenceState state = reference_state(b.start);
      const EulerRun run = run_euler(solver, state, b.pbm_case.end_time, limit, reference.left());
      if (!run.finished) {
        reference.left_out(bins, limit, "over the time budget", run.cpu);
        continue;
      }
      reference.ran(bins, limit, run.cpu, l1_difference(state.number, exact), run.steps);
    }
  }
}

Value speedup_at(double error, const Method& ours, const Method& reference) {
  Value row = Value::object({{"error", error}});
  if (ours.points().empty() || reference.points().empty()) return row.set("ratio", Value());
  const CostAtError mine = cost_at_error(ours.points(), error), theirs = cost_at_error(reference.points(), error);
  if (!mine.reached) return row.set("ratio", Value()).set("how", "the solver did not reach this error in its budget");
  row.set("ratio", theirs.cost / mine.cost).set("solver_s", mine.cost).set("reference_s", theirs.cost);
  row.set("is_lower_bound", !theirs.reached);
  return row.set("how", theirs.reached ? "interpolated between measured runs"
                                       : "lower bound: the reference's most accurate run that fitted into its budget, "
                                         "which is still less accurate than this");
}

}  // namespace

Value work_precision(Effort effort) {
  Method ours("solver", by_effort(effort, 2.0, 40.0, 600.0));
  Method reference("reference", by_effort(effort, 4.0, 110.0, 1500.0));
  run_ours(ours, by_effort<std::vector<int>>(effort, {16, 32, 64}, {16, 32, 64, 128}, {16, 32, 64, 128}));
  std::vector<double> limits{0.1, 0.05, 0.02};
  if (effort == Effort::full) limits.insert(limits.end(), {0.01, 0.005});
  run_reference(reference, by_effort<std::vector<int>>(effort, {16, 32}, {16, 32, 64}, {16, 32, 64}), limits);
  Value rows = Value::array(), left_out = Value::array(), speedups = Value::array();
  for (const Method* method : {&ours, &reference}) {
    for (const Value& row : method->rows()) rows.push(row);
    for (const Value& row : method->all_left_out()) left_out.push(row);
  }
  for (const double error : kErrors) speedups.push(speedup_at(error, ours, reference));
  return Value::object(
      {{"work_precision", rows}, {"speedup_at_error", speedups}, {"work_precision_left_out", left_out}});
}

}  // namespace granary::pbm::bench
