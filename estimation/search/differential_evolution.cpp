// Differential evolution, current-to-best/1/bin, without generations: a child replaces its parent as soon as it is
// known to be better [R. Storn, K. Price, J. Global Optimization 11 (1997) 341; steady state as in E. Ntipteni et al.,
// An asynchronous parallel differential evolution algorithm, ERCOFTAC 2006].
#include <algorithm>

#include "estimation/search/population.hpp"

namespace granary::estimation {
namespace {

// All members cost the same to within this: about the best cost, a parabola of n parameters, the best of 5 n members
// is nearer to its bottom than the worst by a factor of some 20.
constexpr double kSpread = 0.02;

class DifferentialEvolution final : public Population {
 public:
  DifferentialEvolution(const Point& start, std::uint64_t seed)
      : Population(start, seed, std::max<std::size_t>(10, 5 * start.size())) {}

  std::string name() const override { return name_of(Method::differential_evolution); }

  bool converged() const override {
    if (!full()) return false;
    const auto [best, worst] = std::minmax_element(members_.begin(), members_.end(), cheaper);
    return worst->cost - best->cost < kSpread * std::max(1.0, best->cost);
  }

 private:
  struct Child {
    Point at;
    std::size_t parent;
  };

  Point next() override {
    if (!sown(4)) return sow();
    const std::size_t parent = turn_++ % members_.size();
    const Point &a = any().at, &b = any().at;
    const Point& best = std::min_element(members_.begin(), members_.end(), cheaper)->at;
    const double scale = 0.5 + 0.5 * dice_.uniform();  // dithered: one scale may be trapped
    const auto always = static_cast<std::size_t>(dice_.below(static_cast<int>(n_)));
    Point child = members_[parent].at;
    for (std::size_t d = 0; d < n_; ++d)
      if (d == always || dice_.uniform() < 0.9)
        child[d] = reflected(child[d] + scale * (best[d] - child[d]) + scale * (a[d] - b[d]));
    children_.push_back({child, parent});
    return child;
  }

  void learn(const Point& at, const std::optional<Residuals>& residuals) override {
    const auto it = std::find_if(children_.begin(), children_.end(), [&](const Child& c) { return c.at == at; });
    const double cost = residuals ? cost_of(*residuals) : 1e300;
    if (it != children_.end()) {
      Member& parent = members_[it->parent];
      if (residuals && cost <= parent.cost) parent = {at, *residuals, cost};
      children_.erase(it);
    } else if (residuals && !full()) {
      members_.push_back({at, *residuals, cost});
    }
  }

  static bool cheaper(const Member& a, const Member& b) { return a.cost < b.cost; }

  std::vector<Child> children_;
};

}  // namespace

std::unique_ptr<Search> make_differential_evolution(const Point& start, std::uint64_t seed) {
  return std::make_unique<DifferentialEvolution>(start, seed);
}

}  // namespace granary::estimation
