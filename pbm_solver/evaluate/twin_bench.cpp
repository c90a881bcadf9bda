#include "pbm_solver/evaluate/twin_bench.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>

#include "common/math/percentile.hpp"
#include "estimation/estimator/estimator.hpp"
#include "estimation/search/methods.hpp"
#include "pbm_solver/evaluate/experiment_model.hpp"
#include "pbm_solver/evaluate/twin.hpp"

namespace granary::pbm {
namespace {

using estimation::Estimate;
using estimation::Estimator;
using estimation::Method;
using estimation::Outcome;
using estimation::Phase;
using estimation::Trial;
using json::Value;

constexpr double kSecondsAtMost = 10.0;

Outcome outcome_of(const ExperimentModel& model, const std::vector<double>& values, std::vector<double> computed) {
  estimation::Fit fit = estimation::fit_of(model.problem(), computed, values);
  return {std::move(fit.residuals), std::move(fit.held_out), std::move(computed)};
}

std::optional<Outcome> evaluated(const ExperimentModel& model, const std::vector<double>& values) {
  auto computed = model.run(values, kSecondsAtMost);
  if (!computed) return std::nullopt;
  return outcome_of(model, values, *std::move(computed));
}

struct Course {
  Estimate estimate;
  long searched = 0;       ///< evaluations until the search ended for the first time
  long evaluations = 0;    ///< until it was done
  bool converged = false;  ///< the search ended before its evaluations did
  bool found = false;      ///< a fit at least as good as the truth's
};

Course run_twin(const Twin& twin, const TwinBench& bench, Method method, std::uint64_t seed) {
  const auto model = ExperimentModel::prepare(twin.problem, "twin");
  Estimator estimator(twin.problem, {method, seed, bench.most_evaluations});
  estimation::Dice order(seed + 1000);
  std::vector<Trial> flying;
  Course course;
  while (estimator.phase() != Phase::done) {
    while (static_cast<int>(flying.size()) < bench.cores) {
      const auto asked = estimator.ask(1);
      if (asked.empty()) break;
      flying.push_back(asked.front());
    }
    if (flying.empty()) break;
    const auto k = static_cast<std::size_t>(order.below(static_cast<int>(flying.size())));
    std::swap(flying[k], flying.back());
    const Trial trial = flying.back();
    flying.pop_back();
    ++course.evaluations;
    const bool lost = order.uniform() < bench.lost;
    estimator.tell(trial.number, lost ? std::nullopt : evaluated(*model, estimator.values_of(trial)));
    if (estimator.phase() != Phase::search && course.searched == 0) course.searched = course.evaluations;
  }
  course.converged = course.searched < bench.most_evaluations - 8 * static_cast<long>(twin.truth.size());
  course.estimate = estimator.estimate();
  const auto at_truth = evaluated(*model, twin.truth);
  course.found = at_truth && course.estimate.cost <= 1.001 * estimation::cost_of(at_truth->residuals);
  return course;
}

double seconds_now() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Value row_of(Method method, int n_parameters, const TwinBench& bench) {
  const double began = seconds_now();
  double held = 0.0, found = 0.0, converged = 0.0, sampled = 0.0, evaluations = 0.0;
  std::vector<double> searched, all, held_out, chi_square;
  for (int k = 0; k < bench.seeds; ++k) {
    const auto seed = static_cast<std::uint64_t>(bench.first_seed + k);
    const Twin twin = make_twin(n_parameters, seed);
    const Course course = run_twin(twin, bench, method, seed);
    const Estimate& e = course.estimate;
    for (std::size_t p = 0; p < twin.truth.size() && !e.low.empty(); ++p)
      held += e.low[p] <= twin.truth[p] && twin.truth[p] <= e.high[p];
    found += course.found;
    converged += course.converged;
    sampled += e.from_posterior;
    evaluations += static_cast<double>(course.evaluations);
    searched.push_back(static_cast<double>(course.searched));
    all.push_back(static_cast<double>(course.evaluations));
    held_out.push_back(e.held_out.value_or(0.0));
    chi_square.push_back(e.chi_square_per_datum);
  }
  const double n = bench.seeds;
  std::fprintf(stderr, "bench twins: %-24s %d parameters: %.3f held, %.2f found, %.0f evaluations, %.0f s\n",
               estimation::name_of(method).c_str(), n_parameters, held / (n * n_parameters), found / n,
               median(searched), seconds_now() - began);
  return Value::object({{"name", estimation::name_of(method)},
                        {"parameters", n_parameters},
                        {"seeds", bench.seeds},
                        {"recovered_share", held / (n * n_parameters)},
                        {"found_share", found / n},
                        {"converged_share", converged / n},
                        {"evaluations_median", median(searched)},
                        {"evaluations_most", *std::max_element(searched.begin(), searched.end())},
                        {"with_intervals_median", median(all)},
                        {"from_posterior_share", sampled / n},
                        {"chi_square_per_datum_median", median(chi_square)},
                        {"held_out_mean_square_median", median(held_out)},
                        {"evaluation_s", (seconds_now() - began) / std::max(evaluations, 1.0)}});
}

}  // namespace

Value bench_twins(const TwinBench& bench) {
  const auto wanted = [&](Method method) {
    return bench.methods.empty() ||
           std::count(bench.methods.begin(), bench.methods.end(), estimation::name_of(method)) > 0;
  };
  Value rows = Value::array();
  for (const int n : bench.parameters)
    for (const Method method : estimation::kMethods)
      if (wanted(method)) rows.push(row_of(method, n, bench));
  return Value::object({{"methods", rows},
                        {"in_flight", bench.cores},
                        {"lost_share", bench.lost},
                        {"most_evaluations", std::int64_t{bench.most_evaluations}}});
}

Value bench_product_twin(const TwinBench& bench) {
  double warned = 0.0;
  std::string warning;
  for (int k = 0; k < bench.seeds; ++k) {
    const auto seed = static_cast<std::uint64_t>(bench.first_seed + k);
    const Course course = run_twin(make_product_twin(seed), bench, Method::hybrid, seed);
    for (const std::string& sentence : course.estimate.unidentified) {
      const bool right = sentence.rfind("Only the product of aggregation rate and efficiency is known", 0) == 0;
      warned += right;
      if (right || warning.empty()) warning = sentence;
    }
  }
  return Value::object({{"seeds", bench.seeds}, {"warned_share", warned / bench.seeds}, {"warning", warning}});
}

}  // namespace granary::pbm
