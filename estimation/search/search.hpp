// What to try next, from what is known so far. Asynchronous: ask() whenever a core is idle, tell() whenever a result
// arrives, in any order, and some results never arrive. The same seed and the same order of calls give the same trials.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace granary::estimation {

/// A set of parameters in the unit cube: each between its bounds, on its own scale (problem/parameter.hpp).
using Point = std::vector<double>;
/// (model - data) / error of every datum, then (parameter - prior) / error of every prior.
using Residuals = std::vector<double>;

/// Half the sum of squares: minus the log of the likelihood, but for a constant.
double cost_of(const Residuals& residuals);

struct Trial {
  long number = 0;
  Point at;
};

/// The best trial that was told of.
struct Best {
  Point at;
  Residuals residuals;
  double cost = 1e300;
  long trial = -1;  ///< its number; -1: none yet
};

class Search {
 public:
  virtual ~Search() = default;

  /// Never waits for results, and never fails.
  Trial ask();
  /// nullopt: the evaluation failed or was lost. A trial that is told twice, or was never asked, is ignored.
  void tell(long trial, const std::optional<Residuals>& residuals);
  /// A point that was evaluated elsewhere (an earlier search, other rates): known, but nobody waits for it.
  void inform(const Point& at, const Residuals& residuals);

  const Best& best() const { return best_; }
  long asked() const { return asked_; }
  long told() const { return told_; }
  std::size_t waiting() const { return waiting_.size(); }
  /// More trials would not improve the fit by more than a thousandth of its cost or of one datum's.
  virtual bool converged() const = 0;
  virtual std::string name() const = 0;

 protected:
  virtual Point next() = 0;
  virtual void learn(const Point& at, const std::optional<Residuals>& residuals) = 0;
  const std::vector<Trial>& pending() const { return waiting_; }

 private:
  Best best_;
  long asked_ = 0, told_ = 0;
  std::vector<Trial> waiting_;
};

enum class Method { cma_es, differential_evolution, ensemble_kalman, least_squares, hybrid };
inline constexpr Method kMethods[] = {Method::hybrid, Method::cma_es, Method::differential_evolution,
                                      Method::ensemble_kalman, Method::least_squares};
std::string name_of(Method method);

/// A search over `dimensions` parameters. `start`: where to begin (the workflow's own values); the middle if absent.
/// `near`: the start is thought to be close to the best, so `hybrid` descends from there before it looks elsewhere.
std::unique_ptr<Search> make_search(Method method, int dimensions, std::uint64_t seed,
                                    const std::optional<Point>& start = std::nullopt, bool near = false);

}  // namespace granary::estimation
