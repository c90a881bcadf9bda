#include "pbm_solver/model/daughter_distribution.hpp"

#include <algorithm>

namespace granary::pbm {
namespace {

// Twice the first pivot can be divided, also when round-off says otherwise.
constexpr double kRoundOff = 1e-12;

bool divisible_along(const SolidAxis& axis, int i) {
  return axis.absent() || axis.pivot(i) >= 2.0 * axis.pivot(0) * (1.0 - kRoundOff);
}

}  // namespace

DaughterDistribution::DaughterDistribution(const ClassGrid& grid, Breakage::Daughters model) : model_(model) {
  for (int i = 0; i < grid.axis(0).size(); ++i)
    for (int j = 0; j < grid.axis(1).size(); ++j)
      divisible_.push_back(divisible_along(grid.axis(0), i) && divisible_along(grid.axis(1), j));
  if (model_ == Breakage::Daughters::uniform_binary) {
    rows_ = uniform_on(grid.axis(0));
    columns_ = uniform_on(grid.axis(1));
  } else {
    list_fragments(grid, model_);
  }
}

/// u = clamp(uniform in [0, x], p, x - p): density 1/x in between, and a share p/x at each of the two ends.
DaughterDistribution::AxisFragments DaughterDistribution::uniform_on(const SolidAxis& axis) {
  const int n = axis.size();
  AxisFragments f{std::vector<double>(static_cast<std::size_t>(n * n)),
                  std::vector<double>(static_cast<std::size_t>(n * n))};
  const auto add = [&](int parent, int cell, double share, double mean) {
    f.share[static_cast<std::size_t>(parent * n + cell)] += share;
    f.volume[static_cast<std::size_t>(parent * n + cell)] += share * mean;
  };
  if (axis.absent()) {
    add(0, 0, 1.0, 0.0);
    return f;
  }
  const double least = axis.pivot(0);
  for (int i = 0; i < n; ++i) {
    if (!divisible_along(axis, i)) continue;
    const double x = axis.pivot(i), most = std::max(least, x - least);
    add(i, axis.cell(least), least / x, least);
    add(i, axis.cell(most), least / x, most);
    for (int a = 0; a <= i; ++a) {
      const double low = std::max(least, axis.lower_edge(a)), high = std::min(most, axis.lower_edge(a + 1));
      if (high > low) add(i, a, (high - low) / x, 0.5 * (low + high));
    }
  }
  return f;
}

void DaughterDistribution::list_fragments(const ClassGrid& grid, Breakage::Daughters model) {
  const SolidAxis &rows = grid.axis(0), &columns = grid.axis(1);
  // Both sisters of parent k where the first has the share theta of it, counted `share` times.
  const auto add = [&](std::size_t k, double theta, double share) {
    for (const double part : {theta, 1.0 - theta}) {
      const double s1 = part * grid.solid_1()[k], s2 = part * grid.solid_2()[k];
      fragments_.push_back({rows.cell(s1), columns.cell(s2), share, share * s1, share * s2});
    }
  };
  for (std::size_t k = 0; k < grid.size(); ++k) {
    first_.push_back(fragments_.size());
    if (!divisible(k)) continue;
    if (model == Breakage::Daughters::halves) {
      add(k, 0.5, 1.0);
      continue;
    }
    // theta in [0, 1/2] and its sister in [1/2, 1]: the shares below are of that half. Cut where either sister changes
    // its cell.
    double least = 0.0;
    std::vector<double> cuts{0.5};
    for (int solid = 0; solid < 2; ++solid) {
      const SolidAxis& axis = grid.axis(solid);
      const double x = (solid == 0 ? grid.solid_1() : grid.solid_2())[k];
      if (axis.absent()) continue;
      least = std::max(least, std::min(0.5, axis.pivot(0) / x));
      for (int a = 1; a < axis.size(); ++a)
        for (const double cut : {axis.lower_edge(a) / x, 1.0 - axis.lower_edge(a) / x})
          if (cut > 0.0 && cut < 0.5) cuts.push_back(cut);
    }
    std::sort(cuts.begin(), cuts.end());
    add(k, least, 2.0 * least);
    double low = least;
    for (const double cut : cuts) {
      if (cut <= low) continue;
      add(k, 0.5 * (low + cut), 2.0 * (cut - low));
      low = cut;
    }
  }
  first_.push_back(fragments_.size());
}

void DaughterDistribution::add_births(const ClassGrid& grid, const Broken& broken, BirthGrid& births) const {
  if (model_ == Breakage::Daughters::uniform_binary) return add_uniform(grid, broken, births);
  add_listed(grid, broken, births);
}

/// Two passes, one along each solid, since the fragments' shares are products of the two axes'.
void DaughterDistribution::add_uniform(const ClassGrid& grid, const Broken& broken, BirthGrid& births) const {
  const int n1 = grid.axis(0).size(), n2 = grid.axis(1).size();
  struct Row {
    double number = 0.0, solid_1 = 0.0, liquid = 0.0, liquid_1 = 0.0, gas = 0.0, gas_1 = 0.0;
  };
  std::vector<Row> rows(static_cast<std::size_t>(n2));
  for (int a = 0; a < n1; ++a) {
    std::fill(rows.begin(), rows.end(), Row{});
    for (int i = a; i < n1; ++i) {
      const double share = 2.0 * rows_.share[static_cast<std::size_t>(i * n1 + a)];
      const double volume = 2.0 * rows_.volume[static_cast<std::size_t>(i * n1 + a)];
      if (share == 0.0) continue;
      for (int j = 0; j < n2; ++j) {
        const std::size_t k = grid.index(i, j);
        const double per_solid = 1.0 / grid.solid()[k];
        Row& row = rows[static_cast<std::size_t>(j)];
        row.number += share * broken.number[k];
        row.solid_1 += volume * broken.number[k];
        row.liquid += share * per_solid * broken.liquid[k];
        row.liquid_1 += volume * per_solid * broken.liquid[k];
        row.gas += share * per_solid * broken.gas[k];
        row.gas_1 += volume * per_solid * broken.gas[k];
      }
    }
    for (int j = 0; j < n2; ++j) {
      const Row& row = rows[static_cast<std::size_t>(j)];
      if (row.number == 0.0) continue;
      for (int b = 0; b <= j; ++b) {
        const double share = columns_.share[static_cast<std::size_t>(j * n2 + b)];
        const double volume = columns_.volume[static_cast<std::size_t>(j * n2 + b)];
        births.at(a, b) += {share * row.number, share * row.solid_1, volume * row.number,
                            share * row.liquid_1 + volume * row.liquid, share * row.gas_1 + volume * row.gas};
      }
    }
  }
}

void DaughterDistribution::add_listed(const ClassGrid& grid, const Broken& broken, BirthGrid& births) const {
  for (std::size_t k = 0; k < grid.size(); ++k) {
    const double number = broken.number[k];
    if (number == 0.0) continue;
    for (std::size_t f = first_[k]; f < first_[k + 1]; ++f) {
      const Fragment& fragment = fragments_[f];
      const double part = (fragment.solid_1 + fragment.solid_2) / grid.solid()[k];
      births.at(fragment.i, fragment.j) += {fragment.number * number, fragment.solid_1 * number,
                                            fragment.solid_2 * number, part * broken.liquid[k], part * broken.gas[k]};
    }
  }
}

}  // namespace granary::pbm
