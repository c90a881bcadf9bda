#include "pbm_solver/model/births/pair_list.hpp"

namespace granary::pbm {

PairList::PairList(const ClassGrid& grid) : n1_(grid.axis(0).size()), n2_(grid.axis(1).size()) {
  const SolidAxis& rows = grid.axis(0);
  first_pair_.assign(static_cast<std::size_t>(n1_ * n1_), 0);
  row_cell_.assign(static_cast<std::size_t>(n1_ * n1_), n1_);
  for (int i1 = 0; i1 < n1_; ++i1)
    for (int i2 = 0; i2 <= i1; ++i2) {
      const auto at = static_cast<std::size_t>(i1 * n1_ + i2);
      row_cell_[at] = rows.sum_cell(i1, i2);
      first_pair_[at] = size_;
      size_ += i1 == i2 ? long(n2_) * (n2_ + 1) / 2 : long(n2_) * n2_;
    }
  list_columns(grid.axis(1));
}

void PairList::list_columns(const SolidAxis& columns) {
  for (int j = 0; j < n2_; ++j) {
    const std::size_t count = columns_.size();
    columns_.push_back(0);
    const auto add = [&](int first, int last, int cell) {
      columns_.insert(columns_.end(), {first, last, cell});
      ++columns_[count];
    };
    for (int offset = 0; offset < columns.offsets(); ++offset) {
      const PartnerRange range = columns.partners(j, offset);
      if (!range.empty()) add(range.first, range.last, j + offset);
    }
    leaving_.push_back(columns.highest_partner(j) + 1);
  }
}

simd::PairView PairList::view(const double* beta) const {
  return {row_cell_.data(), columns_.data(), leaving_.data(), beta, first_pair_.data()};
}

void PairList::for_each_row(const std::function<void(int, int, int, long)>& row) const {
  for (int i1 = 0; i1 < n1_; ++i1)
    for (int i2 = 0; i2 <= i1; ++i2) {
      const long first = first_pair_[static_cast<std::size_t>(i1 * n1_ + i2)];
      for (int j = 0; j < n2_; ++j) {
        if (i1 == i2) {
          row(i1 * n2_ + j, i1 * n2_, j + 1, first + long(j) * (j + 1) / 2);
        } else {
          row(i1 * n2_ + j, i2 * n2_, j + 1, first + long(j) * j);
          row(i2 * n2_ + j, i1 * n2_, j, first + long(j) * j + j + 1);
        }
      }
    }
}

}  // namespace granary::pbm
