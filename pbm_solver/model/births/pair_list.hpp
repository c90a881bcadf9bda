// Every unordered pair of classes in the order of the double loop, for kernels without structure.
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
  /// Calls row(k, first, count, at) for all pairs: class k with classes first .. first + count - 1, whose values lie at
  /// at .. at + count - 1.
  void for_each_row(const std::function<void(int k, int first, int count, long at)>& row) const;

 private:
  void list_columns(const SolidAxis& columns);

  int n1_, n2_;
  std::vector<int> row_cell_, columns_, leaving_;  ///< see simd::PairView
  std::vector<long> first_pair_;
  long size_ = 0;
};

}  // namespace granary::pbm
