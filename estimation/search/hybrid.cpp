// A global search that becomes a local one: CMA-ES until its cloud is small, or until it has not halved the cost for a
// while; then least squares from the best, which begins with all that is known near by. A least cost may be the least
// of its surroundings only, so descents go on, each from somewhere else, until two have ended as well as the best.
#include <algorithm>
#include <cmath>

#include "estimation/search/local_model.hpp"
#include "estimation/search/methods.hpp"

namespace granary::estimation {
namespace {

constexpr int kMostDescents = 6;

class Hybrid final : public Search {
 public:
  Hybrid(const Point& start, std::uint64_t seed, bool near)
      : n_(start.size()),
        dice_(seed),
        patience_(30 + 10 * static_cast<long>(start.size())),
        global_(make_cma_es(start, seed)) {
    if (near) local_ = make_least_squares(start, seed, 0.03);
  }

  std::string name() const override { return name_of(Method::hybrid); }
  bool converged() const override { return converged_; }

 private:
  Point next() override {
    if (local_ && local_->converged()) end_descent();
    if (!local_ && (global_->converged() || known_ - halved_at_ > patience_)) go_local();
    Search& search = local_ ? *local_ : *global_;
    const Trial trial = search.ask();
    asked_of_.push_back({trial.at, trial.number, searches_});
    return trial.at;
  }

  void learn(const Point& at, const std::optional<Residuals>& residuals) override {
    const auto it = std::find_if(asked_of_.begin(), asked_of_.end(), [&](const Asked& a) { return a.at == at; });
    Search* const search = local_ ? local_.get() : global_.get();
    const bool its_own = it != asked_of_.end() && it->search == searches_;
    if (residuals) {
      ++known_;
      points_.push_back({at, *residuals});
      const double cost = cost_of(*residuals);
      if (its_own && (best_ == nullptr || cost < cost_of(best_->residuals)))
        best_ = std::make_unique<Known>(points_.back());
      if (its_own && cost < 0.5 * halved_) halved_ = cost, halved_at_ = known_;
    }
    if (its_own)
      search->tell(it->number, residuals);
    else if (residuals && local_)
      local_->inform(at, *residuals);
    if (it != asked_of_.end()) asked_of_.erase(it);
  }

  void go_local() {
    halved_at_ = known_;
    if (!best_) return;
    ++searches_;
    local_ = make_least_squares(best_->at, dice_.seed(), 0.03);
    // Least squares takes the best it hears of as its centre: of this descent, not of all.
    for (const Known& k : points_)
      if (cost_of(k.residuals) >= cost_of(best_->residuals)) local_->inform(k.at, k.residuals);
  }

  void end_descent() {
    ends_.push_back(cost_of(best_->residuals));
    const double least = *std::min_element(ends_.begin(), ends_.end());
    const auto as_good =
        std::count_if(ends_.begin(), ends_.end(), [&](double cost) { return cost <= least + 0.1 + 1e-3 * least; });
    converged_ = as_good >= 2 || static_cast<int>(ends_.size()) >= kMostDescents;
    ++searches_;
    local_.reset();
    best_.reset();
    global_ = make_cma_es(dice_.anywhere(n_), dice_.seed());
    halved_ = 1e300;
    halved_at_ = known_;
  }

  struct Asked {
    Point at;
    long number;
    int search;  ///< searches_ when it was asked; an address may be used again
  };

  std::size_t n_;
  Dice dice_;
  int searches_ = 0;  ///< begun before this one
  long patience_, known_ = 0, halved_at_ = 0;
  double halved_ = 1e300;
  std::unique_ptr<Search> global_, local_;
  std::unique_ptr<Known> best_;  ///< of this descent
  std::vector<double> ends_;     ///< cost at the end of each descent
  std::vector<Known> points_;
  std::vector<Asked> asked_of_;
  bool converged_ = false;
};

}  // namespace

std::unique_ptr<Search> make_hybrid(const Point& start, std::uint64_t seed, bool near) {
  return std::make_unique<Hybrid>(start, seed, near);
}

}  // namespace granary::estimation
