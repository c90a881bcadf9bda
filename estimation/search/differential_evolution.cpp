// Differential evolution, current-to-best/1/bin, without generations: a child replaces its parent as soon as it is
// known to be better [R. Storn, K. Price, J. Global Optimization 11 (1997) 341; steady state as in E. Ntipteni et al.,
// An asynchronous parallel differential evolution algorithm, ERCOFTAC 2006].
#include <algorithm>
#include <cmath>

#include "estimation/search/methods.hpp"

namespace granary::estimation {
namespace {

class DifferentialEvolution final : public Search {
 public:
  DifferentialEvolution(const Point& start, std::uint64_t seed)
      : n_(start.size()), dice_(seed), most_(std::max<std::size_t>(10, 5 * n_)), first_(start) {}

  std::string name() const override { return name_of(Method::differential_evolution); }

  bool converged() const override {
    if (members_.size() < most_) return false;
    for (std::size_t d = 0; d < n_; ++d) {
      double low = 1.0, high = 0.0;
      for (const Member& m : members_) {
        low = std::min(low, m.at[d]);
        high = std::max(high, m.at[d]);
      }
      if (high - low > 1e-3) return false;
    }
    return true;
  }

 private:
  struct Member {
    Point at;
    double cost;
  };
  struct Child {
    Point at;
    std::size_t parent;
  };

  Point next() override {
    if (sown_ < most_) return sown_++ == 0 ? first_ : dice_.anywhere(n_);
    if (members_.size() < 4) return dice_.anywhere(n_);
    const auto pick = [&] { return static_cast<std::size_t>(dice_.below(static_cast<int>(members_.size()))); };
    const std::size_t parent = turn_++ % members_.size(), a = pick(), b = pick();
    const auto best = std::min_element(members_.begin(), members_.end(),
                                       [](const Member& x, const Member& y) { return x.cost < y.cost; });
    const double scale = 0.5 + 0.5 * dice_.uniform();  // dithered: one scale may be trapped
    const auto always = static_cast<std::size_t>(dice_.below(static_cast<int>(n_)));
    Point child = members_[parent].at;
    for (std::size_t d = 0; d < n_; ++d)
      if (d == always || dice_.uniform() < 0.9)
        child[d] =
            reflected(child[d] + scale * (best->at[d] - child[d]) + scale * (members_[a].at[d] - members_[b].at[d]));
    children_.push_back({child, parent});
    return child;
  }

  void learn(const Point& at, const std::optional<Residuals>& residuals) override {
    const auto it = std::find_if(children_.begin(), children_.end(), [&](const Child& c) { return c.at == at; });
    const double cost = residuals ? cost_of(*residuals) : 1e300;
    if (it != children_.end()) {
      Member& parent = members_[it->parent];
      if (cost <= parent.cost) parent = {at, cost};
      children_.erase(it);
    } else if (residuals && members_.size() < most_) {
      members_.push_back({at, cost});
    }
  }

  std::size_t n_;
  Dice dice_;
  std::size_t most_, sown_ = 0, turn_ = 0;
  Point first_;
  std::vector<Member> members_;
  std::vector<Child> children_;
};

}  // namespace

std::unique_ptr<Search> make_differential_evolution(const Point& start, std::uint64_t seed) {
  return std::make_unique<DifferentialEvolution>(start, seed);
}

}  // namespace granary::estimation
