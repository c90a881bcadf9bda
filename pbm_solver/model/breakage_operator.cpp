#include "pbm_solver/model/breakage_operator.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "pbm_solver/model/particles.hpp"

namespace granary::pbm {
namespace {

// Twice the first pivot can be divided, also when round-off says otherwise.
constexpr double kRoundOff = 1e-12;

bool divisible_along(const SolidAxis& axis, int i) {
  return axis.absent() || axis.pivot(i) >= 2.0 * axis.pivot(0) * (1.0 - kRoundOff);
}

/// What the fragments of one parent give to the pivots around them.
class PivotWeights {
 public:
  PivotWeights(const ClassGrid& grid, std::size_t parent) : grid_(grid), parent_(parent) {}

  /// `number` fragments with the share `part` of the parent's solids.
  void add(double part, double number) {
    const SolidAxis &rows = grid_.axis(0), &columns = grid_.axis(1);
    const double s1 = part * grid_.solid_1()[parent_], s2 = part * grid_.solid_2()[parent_];
    const PivotShare a = rows.share(rows.cell(s1), s1), b = columns.share(columns.cell(s2), s2);
    for (int di = 0; di < 2; ++di)
      for (int dj = 0; dj < 2; ++dj) {
        const double w = number * (di == 0 ? a.to_lower : a.to_upper) * (dj == 0 ? b.to_lower : b.to_upper);
        if (w != 0.0) weights_[grid_.index(a.lower + di, b.lower + dj)] += w;
      }
  }
  /// Both sisters where the first has the share theta.
  void add_sisters(double theta, double number) {
    add(theta, number);
    add(1.0 - theta, number);
  }
  const std::map<std::size_t, double>& list() const { return weights_; }

 private:
  const ClassGrid& grid_;
  std::size_t parent_;
  std::map<std::size_t, double> weights_;
};

/// The least share of its solids that a fragment of parent k can have: a first pivot of either solid.
double least_share(const ClassGrid& grid, std::size_t k) {
  double least = 0.0;
  for (int solid = 0; solid < 2; ++solid)
    if (const SolidAxis& axis = grid.axis(solid); !axis.absent())
      least = std::max(least, axis.pivot(0) / (solid == 0 ? grid.solid_1() : grid.solid_2())[k]);
  return least;
}

/// theta in [0, 1/2] and its sister in [1/2, 1]: the shares are of that half. Cut where either sister changes its cell.
void add_uniform_shares(const ClassGrid& grid, std::size_t k, PivotWeights& weights) {
  const double least = std::min(0.5, least_share(grid, k));
  std::vector<double> cuts{0.5};
  for (int solid = 0; solid < 2; ++solid) {
    const SolidAxis& axis = grid.axis(solid);
    const double x = (solid == 0 ? grid.solid_1() : grid.solid_2())[k];
    if (axis.absent()) continue;
    for (int a = 1; a < axis.size(); ++a)
      for (const double cut : {axis.lower_edge(a) / x, 1.0 - axis.lower_edge(a) / x})
        if (cut > 0.0 && cut < 0.5) cuts.push_back(cut);
  }
  std::sort(cuts.begin(), cuts.end());
  weights.add_sisters(least, 2.0 * least);
  double low = least;
  for (const double cut : cuts) {
    if (cut <= low) continue;
    weights.add_sisters(0.5 * (low + cut), 2.0 * (cut - low));
    low = cut;
  }
}

/// The rows of the table on both sides of the parent, each with its part. A row without daughters is a parent that does
/// not break: the other has it all.
void add_table(const BreakageTable& table, const ClassGrid& grid, std::size_t k, PivotWeights& weights) {
  std::vector<double> ln_solid;
  std::vector<std::size_t> rows;
  for (std::size_t p = 0; p < table.solid.size(); ++p)
    if (!table.daughters[p].empty()) ln_solid.push_back(std::log(table.solid[p])), rows.push_back(p);
  if (rows.empty()) return;
  const ClassPosition at = position_of(ln_solid, std::log(grid.solid()[k]));
  // Two fragments at least fit into a parent that can be divided, but not more of a size than it holds.
  const double least = std::min(0.5, least_share(grid, k));
  const auto add_row = [&](std::size_t row, double part) {
    for (const BreakageTable::Daughter& daughter : table.daughters[rows[row]]) {
      const double share = std::max(daughter.share, least);
      weights.add(share, part * daughter.number * daughter.share / share);
    }
  };
  const auto lower = static_cast<std::size_t>(at.lower);
  add_row(lower, 1.0 - at.to_upper);
  if (at.to_upper > 0.0) add_row(lower + 1, at.to_upper);
}

}  // namespace

Fragments::Fragments(const ClassGrid& grid, Breakage::Daughters model, const BreakageTable& table)
    : n1_(grid.axis(0).size()), n2_(grid.axis(1).size()), products_(model == Breakage::Daughters::uniform_binary) {
  for (int i = 0; i < n1_; ++i)
    for (int j = 0; j < n2_; ++j)
      divisible_.push_back(divisible_along(grid.axis(0), i) && divisible_along(grid.axis(1), j));
  if (products_) {
    list_uniform(grid.axis(0), along_1_);
    list_uniform(grid.axis(1), along_2_);
  } else {
    list_fragments(grid, model, table);
  }
}

/// u = clamp(uniform in [0, x], p, x - p): density 1/x in between, and a share p/x at each of the two ends.
void Fragments::list_uniform(const SolidAxis& axis, std::vector<double>& along) const {
  const int n = axis.size();
  along.assign(static_cast<std::size_t>(n * n), 0.0);
  if (axis.absent()) {
    along[0] = 1.0;
    return;
  }
  const double least = axis.pivot(0);
  std::vector<double> share(static_cast<std::size_t>(n)), volume(share);
  for (int i = 0; i < n; ++i) {
    if (!divisible_along(axis, i)) continue;
    std::fill(share.begin(), share.end(), 0.0);
    std::fill(volume.begin(), volume.end(), 0.0);
    const auto add = [&](int cell, double part, double mean) {
      share[static_cast<std::size_t>(cell)] += part;
      volume[static_cast<std::size_t>(cell)] += part * mean;
    };
    const double x = axis.pivot(i), most = std::max(least, x - least);
    add(axis.cell(least), least / x, least);
    add(axis.cell(most), least / x, most);
    for (int a = 0; a <= i; ++a) {
      const double low = std::max(least, axis.lower_edge(a)), high = std::min(most, axis.lower_edge(a + 1));
      if (high > low) add(a, (high - low) / x, 0.5 * (low + high));
    }
    for (int a = 0; a <= i; ++a) {
      const double part = share[static_cast<std::size_t>(a)];
      if (part == 0.0) continue;
      const PivotShare to = axis.share(a, volume[static_cast<std::size_t>(a)] / part);
      along[static_cast<std::size_t>(to.lower * n + i)] += part * to.to_lower;
      if (to.to_upper != 0.0) along[static_cast<std::size_t>((to.lower + 1) * n + i)] += part * to.to_upper;
    }
  }
}

void Fragments::list_fragments(const ClassGrid& grid, Breakage::Daughters model, const BreakageTable& table) {
  diagonal_.assign(grid.size(), 0.0);
  for (std::size_t k = 0; k < grid.size(); ++k) {
    first_.push_back(static_cast<int>(to_.size()));
    if (!divisible_[k]) continue;
    PivotWeights weights(grid, k);
    if (model == Breakage::Daughters::halves)
      weights.add_sisters(0.5, 1.0);
    else if (model == Breakage::Daughters::same_composition)
      add_uniform_shares(grid, k, weights);
    else
      add_table(table, grid, k, weights);
    for (const auto& [to, w] : weights.list()) {
      to_.push_back(static_cast<int>(to));
      weight_.push_back(w);
      if (to == k) diagonal_[k] = w;
    }
  }
  first_.push_back(static_cast<int>(to_.size()));
}

double Fragments::weight(std::size_t to, std::size_t parent) const {
  if (products_) {
    const auto n1 = static_cast<std::size_t>(n1_), n2 = static_cast<std::size_t>(n2_);
    return divisible_[parent] ? 2.0 * along_1_[to / n2 * n1 + parent / n2] * along_2_[to % n2 * n2 + parent % n2] : 0.0;
  }
  double sum = 0.0;
  for (int f = first_[parent]; f < first_[parent + 1]; ++f)
    if (to_[static_cast<std::size_t>(f)] == static_cast<int>(to)) sum += weight_[static_cast<std::size_t>(f)];
  return sum;
}

simd::FragmentView Fragments::view() const {
  if (products_) return {along_1_.data(), along_2_.data(), 2.0, nullptr, nullptr, nullptr, nullptr};
  return {nullptr, nullptr, 1.0, first_.data(), to_.data(), weight_.data(), diagonal_.data()};
}

}  // namespace granary::pbm
