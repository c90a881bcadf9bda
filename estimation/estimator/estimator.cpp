#include "estimation/estimator/estimator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/assert.hpp"
#include "estimation/estimator/differences.hpp"
#include "estimation/estimator/identifiability.hpp"
#include "estimation/trust/posterior.hpp"
#include "estimation/trust/uncertainty.hpp"

namespace granary::estimation {
namespace {

// Half a sum of squares by which a better fit must be better for the search to begin again: less is within the
// intervals anyway.
constexpr double kWorthSearching = 0.1;
constexpr int kMostReturns = 3;
constexpr double kEnoughSamples = 50.0;  // effective ones, for quantiles rather than Laplace's intervals
constexpr double kLargeMisfit = 2.0;     // chi^2 per datum
constexpr double kNearBy = 1e-3;         // in the unit cube: two points that tell the same

double distance(const Point& a, const Point& b) {
  double square = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) square += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(square);
}

/// To the end of the search and the differences, by `hybrid`: medians of the twin experiments in docs/estimation.md.
int usual_evaluations(int parameters) { return 57 * parameters + 25 * parameters * parameters; }

std::vector<std::string> doubts_of(const Estimate& e, std::size_t n_held_out) {
  std::vector<std::string> doubts;
  if (e.chi_square_per_datum > kLargeMisfit)
    doubts.push_back(
        fmt::format("The model misses the data by more than their errors say (chi^2 per datum {:.3g}): it "
                    "lacks something, the errors are larger, or the search has not come to its end.",
                    e.chi_square_per_datum));
  if (!e.held_out) return doubts;
  const double by_chance = mean_square_by_chance(n_held_out);
  if (*e.held_out > by_chance)
    doubts.push_back(
        fmt::format("The {} held-out data are not predicted: the mean square of their residuals is {:.3g} "
                    "errors; by chance alone it stays below {:.2g} in 95 % of cases.",
                    n_held_out, *e.held_out, by_chance));
  return doubts;
}

}  // namespace

std::string name_of(Phase phase) {
  constexpr const char* kNames[] = {"search", "uncertainty", "posterior", "done"};
  return kNames[static_cast<int>(phase)];
}

struct Estimator::State {
  enum class Purpose { again, search, difference, posterior };
  struct Asked {
    Point at;
    Purpose purpose;
    long inner;  ///< number within the search, of the difference, or of the return to the search before the posterior
  };
  struct Known {
    Point at;
    double cost;
  };
  struct BestTrial {
    Point at;
    Outcome outcome;
    double cost = 1e300;
    long trial = -1;
  };

  State(Problem p, Settings s, int v) : problem(std::move(p)), settings(s), version(v) {
    search = make_search(settings.method, dimensions(), settings.seed, start_of(problem));
  }

  int dimensions() const { return static_cast<int>(problem.parameters.size()); }
  /// Of the evaluations: for the differences, some of which may be lost.
  long reserved() const { return 3L * dimensions(); }

  std::optional<Trial> next() {
    if (asked_now >= settings.most_evaluations) return std::nullopt;
    if (phase == Phase::search && again.empty() && best.trial >= 0) {
      const bool last_ones = asked_now >= settings.most_evaluations - reserved();
      // The best may still be on its way, and the differences are to be about it.
      if (last_ones && !waiting.empty()) return std::nullopt;
      if (last_ones || search->converged()) take_differences();
    }
    ++asked_now;
    const long number = next_number++;
    const auto [it, is_new] = waiting.emplace(number, what_next());
    return Trial{number, it->second.at};
  }

  Asked what_next() {
    if (!again.empty()) {
      Asked asked{again.back(), Purpose::again, 0};
      again.pop_back();
      return asked;
    }
    if (phase == Phase::uncertainty)
      if (const auto k = differences->next())
        return {differences->point(*k), Purpose::difference, static_cast<long>(*k)};
    if (posterior) return {posterior->ask(), Purpose::posterior, returns};
    const Trial trial = search->ask();
    return {trial.at, Purpose::search, trial.number};
  }

  void tell(long number, const std::optional<Outcome>& told) {
    const auto it = waiting.find(number);
    if (it == waiting.end()) {
      if (number < first_of_version) ++late;
      return;
    }
    const Asked asked = std::move(it->second);
    waiting.erase(it);
    const double cost = told ? cost_of(told->residuals) : 1e300;
    const std::optional<Outcome> outcome = cost < 1e300 ? told : std::nullopt;
    outcome ? ++evaluated_now : ++failed;
    if (outcome) note(asked.at, *outcome, cost, number);
    pass_on(asked, outcome);
    settle();
  }

  void note(const Point& at, const Outcome& outcome, double cost, long trial) {
    known.push_back({at, cost});
    if (cost < best.cost) best = {at, outcome, cost, trial};
  }

  void pass_on(const Asked& asked, const std::optional<Outcome>& outcome) {
    const std::optional<Residuals> residuals = outcome ? std::optional(outcome->residuals) : std::nullopt;
    switch (asked.purpose) {
      case Purpose::again:
        if (residuals) search->inform(asked.at, *residuals);
        break;
      case Purpose::search:
        search->tell(asked.inner, residuals);
        break;
      case Purpose::difference:
        if (differences && differences->is(asked.inner, asked.at)) differences->tell(asked.inner, residuals);
        break;
      case Purpose::posterior:
        // One that was drawn from the posterior of an earlier search would count wrongly in this one.
        if (posterior && asked.inner == returns) posterior->tell(asked.at, residuals);
        break;
    }
  }

  /// What follows from what is known now.
  void settle() {
    const bool last = asked_now >= settings.most_evaluations && waiting.empty();
    const bool enough_left = asked_now < settings.most_evaluations - 2 * reserved();
    if (phase == Phase::search && last && best.trial >= 0) take_differences();
    if (phase == Phase::uncertainty || phase == Phase::posterior)
      if (best.cost < differences->cost() - kWorthSearching && returns < kMostReturns && enough_left)
        return search_again();
    if (phase == Phase::uncertainty && (differences->complete() || last)) begin_posterior();
    // Seldom: all weights are worked out anew for it.
    if (phase == Phase::posterior && posterior->samples() % 50 == 0 && posterior->converged()) phase = Phase::done;
    if (last) phase = Phase::done;
  }

  void take_differences() {
    phase = Phase::uncertainty;
    differences.emplace(best.at, best.outcome.residuals, best.cost);
  }

  void search_again() {
    ++returns;
    phase = Phase::search;
    search = make_search(Method::least_squares, dimensions(), seed(), best.at);
    search->inform(best.at, best.outcome.residuals);
    differences.reset();
    posterior.reset();
  }

  void begin_posterior() {
    phase = Phase::posterior;
    uncertainty = differences->uncertainty();
    posterior.emplace(differences->centre(), uncertainty.covariance, seed(),
                      std::max(1.0, uncertainty.chi_square_per_datum));
  }

  std::uint64_t seed() const {
    return settings.seed + 1000003ULL * (static_cast<std::uint64_t>(version) + 64 * returns);
  }

  /// The best points, the best one first, none of them next to another. Those of the version before that nobody has
  /// come to try in this one (it was short) are still the best known.
  std::vector<Point> best_points(std::size_t count) {
    std::stable_sort(known.begin(), known.end(), [](const Known& a, const Known& b) { return a.cost < b.cost; });
    std::vector<Point> points;
    const auto is_new = [](const auto& list, const Point& at) {
      return std::all_of(list.begin(), list.end(), [&](const Point& p) { return distance(p, at) > kNearBy; });
    };
    std::vector<Point> tried;
    for (const Known& k : known) tried.push_back(k.at);
    for (const Point& at : remembered)
      if (points.size() < count && is_new(tried, at)) points.push_back(at);
    for (const Point& at : tried)
      if (points.size() < count && is_new(points, at)) points.push_back(at);
    return points;
  }

  void change(Problem to, int v) {
    GRANARY_ASSERT(to.parameters.size() == problem.parameters.size());
    const auto points = best_points(static_cast<std::size_t>(2 * dimensions() + 4));
    remembered = points;
    again.assign(points.rbegin(), points.rend());
    problem = std::move(to);
    version = v;
    returns = 0;
    search = make_search(settings.method, dimensions(), seed(), points.empty() ? start_of(problem) : points.front(),
                         !points.empty());
    evaluated_before += evaluated_now;
    evaluated_now = asked_now = 0;
    first_of_version = next_number;
    waiting.clear();
    known.clear();
    best = {};
    differences.reset();
    posterior.reset();
    phase = Phase::search;
  }

  Problem problem;
  Settings settings;
  int version;
  Phase phase = Phase::search;
  std::unique_ptr<Search> search;
  std::vector<Point> remembered;           ///< best points of the version before, the best one first
  std::vector<Point> again;                ///< those of them still to be tried, the best one last
  std::optional<Differences> differences;  ///< from phase uncertainty on
  Uncertainty uncertainty;                 ///< from phase posterior on
  std::optional<Posterior> posterior;      ///< likewise
  int returns = 0;                         ///< from there to the search
  std::map<long, Asked> waiting;
  std::vector<Known> known;
  BestTrial best;
  long next_number = 0, first_of_version = 0, asked_now = 0, evaluated_now = 0, evaluated_before = 0, failed = 0;
  long late = 0;
};

Estimator::Estimator(Problem problem, Settings settings, int version)
    : state_(std::make_unique<State>(std::move(problem), settings, version)) {}
Estimator::Estimator(Estimator&&) noexcept = default;
Estimator& Estimator::operator=(Estimator&&) noexcept = default;
Estimator::~Estimator() = default;

std::vector<Trial> Estimator::ask(int count) {
  std::vector<Trial> trials;
  while (static_cast<int>(trials.size()) < count) {
    auto trial = state_->next();
    if (!trial) break;
    trials.push_back(*std::move(trial));
  }
  return trials;
}

void Estimator::tell(long trial, const std::optional<Outcome>& outcome) { state_->tell(trial, outcome); }
void Estimator::change(Problem problem, int version) { state_->change(std::move(problem), version); }

void Estimator::inform(const std::vector<double>& values, const Outcome& outcome) {
  const double cost = cost_of(outcome.residuals);
  if (cost >= 1e300) return;
  const Point at = places_of(state_->problem.parameters, values);
  ++state_->evaluated_now;
  state_->note(at, outcome, cost, state_->next_number++);
  state_->search->inform(at, outcome.residuals);
}

const Problem& Estimator::problem() const { return state_->problem; }
int Estimator::version() const { return state_->version; }
Phase Estimator::phase() const { return state_->phase; }
std::vector<double> Estimator::values_of(const Trial& trial) const {
  return values_at(state_->problem.parameters, trial.at);
}
std::size_t Estimator::waiting() const { return state_->waiting.size(); }
long Estimator::asked() const { return state_->next_number; }
long Estimator::evaluated() const { return state_->evaluated_before + state_->evaluated_now; }
long Estimator::evaluated_now() const { return state_->evaluated_now; }
long Estimator::failed() const { return state_->failed; }
long Estimator::late() const { return state_->late; }

std::optional<Fitted> Estimator::best() const {
  const auto& best = state_->best;
  if (best.trial < 0) return std::nullopt;
  return Fitted{values_at(state_->problem.parameters, best.at), state_->version, best.trial, best.cost};
}

Estimate Estimator::estimate() const {
  const State& s = *state_;
  Estimate e;
  e.version = s.version;
  e.trial = s.best.trial;
  if (e.trial < 0) return e;
  e.values = values_at(s.problem.parameters, s.best.at);
  e.cost = s.best.cost;
  e.model = s.best.outcome.model;
  const auto data = static_cast<double>(s.best.outcome.residuals.size());
  e.chi_square_per_datum = 2.0 * e.cost / std::max(data - s.dimensions(), 1.0);
  if (const auto& held_out = s.best.outcome.held_out; !held_out.empty())
    e.held_out = 2.0 * cost_of(held_out) / static_cast<double>(held_out.size());
  e.doubts = doubts_of(e, s.best.outcome.held_out.size());
  e.intervals = fmt::format("none yet: {} evaluations{}, and about {} are needed", s.evaluated_now,
                            s.version > 1 ? " with the present rates" : "", usual_evaluations(s.dimensions()));
  if (!s.posterior) return e;

  const Uncertainty& u = s.uncertainty;
  e.correlation = u.correlation;
  e.at_bound = u.at_bound;
  for (const Unidentified& one : u.unidentified) e.unidentified.push_back(sentence_of(one, s.problem.parameters));
  // The best may have moved since, and no evaluations been left for differences about it.
  for (std::size_t k = 0; k < e.values.size(); ++k) {
    const double moved = s.best.at[k] - s.differences->centre()[k];
    e.low.push_back(s.problem.parameters[k].value_at(std::clamp(u.low[k] + moved, 0.0, 1.0)));
    e.high.push_back(s.problem.parameters[k].value_at(std::clamp(u.high[k] + moved, 0.0, 1.0)));
  }
  e.effective_samples = s.posterior->samples() > 0 ? s.posterior->effective_samples() : 0.0;
  e.from_posterior = e.effective_samples >= kEnoughSamples;
  e.intervals = e.from_posterior ? fmt::format("of the posterior, {:.0f} effective samples", e.effective_samples)
                                 : fmt::format(
                                       "of a parabola at the best fit; the sample of the posterior has {:.0f} "
                                       "effective ones, and {:.0f} are needed",
                                       e.effective_samples, kEnoughSamples);
  for (std::size_t k = 0; e.from_posterior && k < e.values.size(); ++k) {
    const auto interval = s.posterior->interval(k);
    e.low[k] = s.problem.parameters[k].value_at(interval->low);
    e.high[k] = s.problem.parameters[k].value_at(interval->high);
  }
  return e;
}

json::Value to_json(const Estimate& e, const std::vector<Parameter>& parameters) {
  json::Value list = json::Value::array();
  for (std::size_t k = 0; k < e.values.size(); ++k) {
    json::Value one =
        json::Value::object({{"name", parameters[k].name}, {"pointer", parameters[k].pointer}, {"value", e.values[k]}});
    if (!e.low.empty())
      one.set("low", e.low[k]).set("high", e.high[k]).set("at_bound", static_cast<bool>(e.at_bound[k]));
    list.push(one);
  }
  return json::Value::object({{"version", e.version},
                              {"trial", e.trial},
                              {"parameters", list},
                              {"from_posterior", e.from_posterior},
                              {"effective_samples", e.effective_samples},
                              {"correlation", e.correlation},
                              {"unidentified", e.unidentified},
                              {"doubts", e.doubts},
                              {"intervals", e.intervals},
                              {"cost", e.cost},
                              {"chi_square_per_datum", e.chi_square_per_datum},
                              {"held_out_mean_square", e.held_out ? json::Value(*e.held_out) : json::Value()},
                              {"model", e.model}});
}

}  // namespace granary::estimation
