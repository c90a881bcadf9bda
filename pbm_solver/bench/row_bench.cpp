#include "pbm_solver/bench/row_bench.hpp"

#include <array>
#include <vector>

#include "pbm_solver/bench/bench_cases.hpp"
#include "pbm_solver/bench/measure.hpp"
#include "pbm_solver/bench/rates_timer.hpp"
#include "pbm_solver/parallel/rank_exchange.hpp"
#include "pbm_solver/time/simulation.hpp"

namespace granary::pbm::bench {
namespace {

using json::Value;

Value statistics(const std::vector<double>& seconds) {
  return Value::object({{"least_s", percentile(seconds, 0.0)},
                        {"p10_s", percentile(seconds, 0.1)},
                        {"median_s", median(seconds)},
                        {"samples", seconds.size()}});
}

/// Rank 0's clock, so that all go on and end together; the reduction is what a step's control costs as well.
bool time_is_left(const Communicator& ranks, double deadline) {
  std::array<double, 1> over{ranks.first() && wall_clock() >= deadline ? 1.0 : 0.0};
  ranks.max(over);
  return over[0] == 0.0;
}

std::vector<double> time_rates(const BenchCase& b, RankExchange& exchange, const Communicator& ranks, int threads,
                               double seconds) {
  SolverRates solver(b.pbm_case, b.start, exchange, threads);
  for (int warm_up = 0; warm_up < 10; ++warm_up) solver.evaluate();
  std::vector<double> samples;
  const double deadline = wall_clock() + seconds;
  for (double began = wall_clock(); time_is_left(ranks, deadline);) {
    solver.evaluate();
    const double now = wall_clock();
    samples.push_back(now - began);
    began = now;
  }
  return samples;
}

}  // namespace

Result<Value> row_timings(const Communicator& ranks, int threads, double seconds) {
  const BenchCase b = row_case();
  RankExchange exchange(ranks, b.pbm_case.compartments.count);
  const std::vector<double> alone = time_rates(b, exchange, ranks, threads, seconds);

  Simulation simulation(b.pbm_case, b.start, exchange, threads);
  std::vector<double> in_run;
  const double deadline = wall_clock() + seconds;
  double began = wall_clock();
  std::int64_t rhs = 0;
  GRANARY_TRY(const bool reached, simulation.advance(b.pbm_case.end_time, [&] {
    const double now = wall_clock();
    const std::int64_t more = simulation.work().rhs_evaluations - rhs;
    in_run.push_back((now - began) / static_cast<double>(more));
    rhs += more;
    began = now;
    return time_is_left(ranks, deadline);
  }));
  static_cast<void>(reached);
  return Value::object({{"ranks", ranks.size()},
                        {"threads", threads},
                        {"rhs_alone", statistics(alone)},
                        {"in_run", statistics(in_run)},
                        {"steps", simulation.work().steps},
                        {"reached_s", simulation.time()}});
}

}  // namespace granary::pbm::bench
