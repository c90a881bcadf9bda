// The cell average written plainly, pair by pair and cell by cell: how the exact cases put their start on the pivots,
// and what the solver's own sharing (model/simd) is held against in tests.
#pragma once

#include <span>
#include <vector>

#include "pbm_solver/model/class_grid.hpp"

namespace granary::pbm {

/// Rates of what is born: particles [1/s] and the volumes they carry [m^3/s].
struct Birth {
  double number = 0.0;
  double solid_1 = 0.0;
  double solid_2 = 0.0;
  double liquid = 0.0;
  double gas = 0.0;

  Birth& operator+=(const Birth& other) {
    number += other.number, solid_1 += other.solid_1, solid_2 += other.solid_2, liquid += other.liquid,
        gas += other.gas;
    return *this;
  }
};

/// Births by cell, with one more row and column for what lands above the grid: no branch where they are collected.
class BirthGrid {
 public:
  explicit BirthGrid(const ClassGrid& grid)
      : rows_(grid.axis(0).size() + 1),
        columns_(grid.axis(1).size() + 1),
        births_(static_cast<std::size_t>(rows_ * columns_)) {}

  void clear() { births_.assign(births_.size(), Birth{}); }
  Birth* row(int i) { return &births_[static_cast<std::size_t>(i * columns_)]; }
  const Birth* row(int i) const { return &births_[static_cast<std::size_t>(i * columns_)]; }
  Birth& at(int i, int j) { return row(i)[j]; }
  const Birth& at(int i, int j) const { return row(i)[j]; }
  void add(const BirthGrid& other) {
    for (std::size_t k = 0; k < births_.size(); ++k) births_[k] += other.births_[k];
  }
  /// All that landed above the last pivot of either solid.
  Birth oversize() const;

 private:
  int rows_, columns_;
  std::vector<Birth> births_;
};

/// Rates of change of the three fields of one compartment, shape (n_classes) each.
struct FieldRates {
  std::span<double> number;  ///< [1/s]
  std::span<double> liquid;  ///< [m^3/s]
  std::span<double> gas;     ///< [m^3/s]
};

/// Adds the births to the rates, shared by tensor weights between up to four pivots:
///
///   w(i,j) = w1(i) w2(j),   sum w = 1,   sum w x1 = mean s1,   sum w x2 = mean s2
///
/// so number and both solids survive to round-off. Liquid and gas go with the solid volume, w (x1+x2) / mean(s1+s2):
/// they survive too, and a population of one composition keeps it. Source: [kumar2006], [kumar2008] in
/// docs/pbm_equations.md.
void share_births(const ClassGrid& grid, const BirthGrid& births, FieldRates rates);

}  // namespace granary::pbm
