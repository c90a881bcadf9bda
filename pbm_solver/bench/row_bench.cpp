#include "pbm_solver/bench/row_bench.hpp"

#include <array>
#include <vector>

#include "common/math/percentile.hpp"
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

/// Runs of the case, again and again until the time is over; a sample a step.
Result<std::vector<double>> time_runs(const BenchCase& b, RankExchange& exchange, const Communicator& ranks,
                                      int threads, double seconds) {
  std::vector<double> samples;
  const double deadline = wall_clock() + seconds;
  for (bool going = true; going;) {
    Simulation simulation(b.pbm_case, b.start, exchange, threads);
    std::int64_t rhs = 0;
    double began = wall_clock();
    const auto after_step = [&] {
      const double now = wall_clock();
      const std::int64_t more = simulation.work().rhs_evaluations - rhs;
      samples.push_back((now - began) / static_cast<double>(more));
      rhs += more;
      going = time_is_left(ranks, deadline);
      began = wall_clock();
      return going;
    };
    GRANARY_TRY(const bool reached, simulation.advance(b.pbm_case.end_time, after_step));
    static_cast<void>(reached);
  }
  return samples;
}

}  // namespace

Result<Value> row_timings(const Communicator& ranks, int threads, double seconds) {
  const BenchCase b = row_case();
  RankExchange exchange(ranks, b.pbm_case.compartments.count);
  const std::vector<double> alone = time_rates(b, exchange, ranks, threads, seconds);

  GRANARY_TRY(const std::vector<double> in_run, time_runs(b, exchange, ranks, threads, seconds));
  return Value::object({{"ranks", ranks.size()},
                        {"threads", threads},
                        {"rhs_alone", statistics(alone)},
                        {"in_run", statistics(in_run)}});
}

}  // namespace granary::pbm::bench
