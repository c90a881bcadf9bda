#include "pbm_solver/model/births/pair_list.hpp"

namespace granary::pbm {

PairList::PairList(const ClassGrid& grid)
    : n2_(grid.axis(1).size()), size_(static_cast<long>(grid.size()) * static_cast<long>(grid.size() + 1) / 2) {
  list_blocks(grid.axis(0));
  list_columns(grid.axis(1));
}

/// Rows side by side whose sums with i1 fall into the same cells, in blocks as even as they can be.
void PairList::list_blocks(const SolidAxis& rows) {
  constexpr int most = simd::PairBlock::most_rows;
  for (int i1 = 0; i1 < rows.size(); ++i1) {
    for (int first = 0, end; first < i1; first = end) {
      const int cells = rows.sum_cell(i1, first);
      for (end = first + 1; end < i1 && rows.sum_cell(i1, end) == cells;) ++end;
      for (int blocks = (end - first + most - 1) / most, count; blocks > 0; first += count, --blocks) {
        count = (end - first + blocks - 1) / blocks;
        blocks_.push_back({i1, first, count, cells});
      }
    }
    blocks_.push_back({i1, i1, 1, rows.sum_cell(i1, i1)});
  }
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
  return {blocks_.data(), static_cast<int>(blocks_.size()), columns_.data(), leaving_.data(), beta};
}

void PairList::for_each_row(const std::function<void(int, int, int, long, int)>& row) const {
  long at = 0;
  for (const simd::PairBlock& b : blocks_)
    for (int j = 0; j < n2_; ++j) {
      const int of_1 = b.i1 * n2_ + j;
      if (b.i1 == b.i2) {
        row(of_1, b.i1 * n2_, j + 1, at, 1);
        at += j + 1;
        continue;
      }
      for (int r = 0; r < b.rows; ++r) {
        const int first = (b.i2 + r) * n2_;
        row(of_1, first, j + 1, at + r, 2 * b.rows);
        row(first + j, b.i1 * n2_, j, at + b.rows + r, 2 * b.rows);
      }
      at += static_cast<long>(b.rows) * (2 * j + 1);
    }
}

}  // namespace granary::pbm
