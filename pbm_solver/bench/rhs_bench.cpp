#include "pbm_solver/bench/rhs_bench.hpp"

#include <fmt/format.h>

#include <string>

#include "pbm_solver/bench/bench_cases.hpp"
#include "pbm_solver/bench/measure.hpp"
#include "pbm_solver/bench/rates_timer.hpp"
#include "pbm_solver/bench/reference_solver.hpp"

namespace granary::pbm::bench {
namespace {

using json::Value;

struct Row {
  int bins, compartments;
  KernelKind kernel;
  int n_classes;
};

const char* name_of(KernelKind kernel) {
  switch (kernel) {
    case KernelKind::constant:
      return "constant";
    case KernelKind::classes:
      return "dem classes";
    case KernelKind::stokes:
      return "dem classes x stokes";
  }
  return "";
}

/// Of the largest cases one compartment is timed, all of them only once and in the longer benches: they do not see each
/// other here.
bool one_for_all(const Row& row, Effort effort) {
  if (row.compartments == 1 || row.bins < 64) return false;
  return effort == Effort::quick || (effort == Effort::usual && row.n_classes != 8);
}

Value measure(const Row& row, Effort effort) {
  const BenchCase b = operator_case(row.bins, row.compartments, row.kernel, row.n_classes);
  Alone alone(row.compartments);
  SolverRates ours(b.pbm_case, b.start, alone, 1);
  std::vector<Contender> contenders{{[&] { ours.evaluate(); }, by_effort(effort, 0.2, 2.0, 5.0)}};
  Value json = Value::object({{"grid", fmt::format("{0}x{0}x{1}", row.bins, row.compartments)},
                              {"classes", row.n_classes},
                              {"kernel", name_of(row.kernel)},
                              {"cores", 1}});
  const int rounds = by_effort(effort, 5, 11, 21);
  if (row.kernel == KernelKind::stokes) {
    contenders.push_back({[&] { ours.refresh(); }, by_effort(effort, 0.2, 2.0, 5.0)});
    const std::vector<Timing> timings = time_in_turn(contenders, rounds);
    return json.set("solver_s", timings[0].seconds)
        .set("reference_s", Value())
        .set("ratio", Value())
        .set("kernel_refresh_s", timings[1].seconds);
  }
  ReferenceSolver reference(b.pbm_case), bisecting(b.pbm_case, CellSearch::bisection);
  const ReferenceState state = reference_state(b.start);
  ReferenceState rates = state;
  const bool one = one_for_all(row, effort);
  for (ReferenceSolver* solver : {&reference, &bisecting})
    contenders.push_back({[&, solver] {
                            if (one)
                              solver->rates_of_compartment(0, state, rates);
                            else
                              solver->rates(state, rates);
                          },
                          by_effort(effort, 0.5, 2.0, 20.0)});
  const std::vector<Timing> timings = time_in_turn(contenders, rounds);
  const double ours_s = timings[0].seconds, times = one ? row.compartments : 1;
  const std::string of = one ? fmt::format("1 compartment, times {}", row.compartments) : "all compartments";
  const int n = timings[1].rounds;
  return json.set("solver_s", ours_s)
      .set("reference_s", timings[1].seconds * times)
      .set("ratio", timings[1].seconds * times / ours_s)
      .set("reference_how", n == 1 ? "one evaluation of " + of : fmt::format("median of {} rounds of {}", n, of))
      .set("bisecting_reference_s", timings[2].seconds * times)
      .set("ratio_to_bisecting", timings[2].seconds * times / ours_s);
}

}  // namespace

Value rhs_timings(Effort effort) {
  Value rows = Value::array();
  struct Size {
    int bins, compartments;
  };
  for (const Size s : {Size{16, 16}, Size{32, 16}, Size{64, 16}, Size{64, 1}}) {
    rows.push(measure({s.bins, s.compartments, KernelKind::classes, 8}, effort));
    rows.push(measure({s.bins, s.compartments, KernelKind::classes, 16}, effort));
    rows.push(measure({s.bins, s.compartments, KernelKind::constant, 1}, effort));
    rows.push(measure({s.bins, s.compartments, KernelKind::stokes, 8}, effort));
  }
  return Value::object({{"rhs", rows}});
}

}  // namespace granary::pbm::bench
