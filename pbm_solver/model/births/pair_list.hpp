// Every unordered pair of classes, in the order in which they meet, for kernels without structure.
#pragma once

#include <functional>
#include <vector>

#include "pbm_solver/model/class_grid.hpp"
#include "pbm_solver/model/simd/lanes.hpp"
#include "pbm_solver/model/simd/operations.hpp"

namespace granary::pbm {

class PairList {
 public:
  explicit PairList(const ClassGrid& grid);

  long size() const { return size_; }
  /// beta of size() pairs, [pair][lanes].
  simd::PairView view(const double* beta) const;
  /// Calls row(k, first, count, at, step) for all pairs: class k with classes first .. first + count - 1, whose values
  /// lie at at, at + step ...
  void for_each_row(const std::function<void(int k, int first, int count, long at, int step)>& row) const;

 private:
  void list_blocks(const SolidAxis& rows);
  void list_columns(const SolidAxis& columns);

  int n2_;
  std::vector<simd::PairBlock> blocks_;
  std::vector<int> columns_, leaving_;  ///< see simd::PairView
  long size_;
};

}  // namespace granary::pbm
