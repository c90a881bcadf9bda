#include "pbm_solver/model/births/birth_plan.hpp"

#include <algorithm>
#include <map>

namespace granary::pbm {
namespace {

constexpr int kNone = -1;
constexpr int kUnset = -2;

}  // namespace

/// Compiles one row of the grid after the other; only what a product asks for is computed.
class BirthCompiler {
 public:
  BirthCompiler(const ClassGrid& grid, const std::vector<int>& group, int n_groups)
      : rows_(&grid.axis(0)),
        columns_(&grid.axis(1)),
        group_(&group),
        n_groups_(n_groups),
        n1_(grid.axis(0).size()),
        n2_(grid.axis(1).size()) {}

  void compile(BirthPlan& plan) {
    place_slots();
    // The first pass finds which running column sums are ever asked for, the second one emits the code.
    wanted_until_.assign(static_cast<std::size_t>(n_groups_ * n2_), kNone);
    for (const bool emit : {false, true}) {
      code_.clear();
      products_ = 0;
      code_.insert(code_.end(), {n1_, far_, n_groups_ * n2_});
      list_run_prefixes();
      far_top_ = kNone;
      for (int i = 0; i < n1_; ++i) compile_row(i, emit);
    }
    plan.code_ = std::move(code_);
    plan.n_slots_ = n_slots_;
    plan.n_products_ = products_;
  }

 private:
  using Terms = std::vector<int>;
  struct Product {
    int unit;
    Terms sum;
  };

  int slot(int i, int j) const { return i * n2_ + j; }
  int group(int i, int j) const { return (*group_)[static_cast<std::size_t>(i * n2_ + j)]; }
  int pair(int a, int b) const { return a * n_groups_ + b; }

  void place_slots() {
    const int n = n1_ * n2_;
    row_prefix_ = n;
    column_prefix_ = 2 * n;
    far_ = 3 * n;
    column_ = far_ + n_groups_ * n2_;
    row_ = column_ + n_groups_ * rows_->offsets() * n2_;
    row_far_ = row_ + n_groups_ * columns_->offsets() * n2_;
    block_ = row_far_ + n_groups_ * n2_;
    n_slots_ = block_ + n_groups_ * rows_->offsets() * n2_;
  }

  /// Running sums within one group along each row and each column: code of the form (count, d, a, b ...).
  void list_run_prefixes() {
    along_row_.assign(static_cast<std::size_t>(n1_ * n2_), 0);
    along_column_ = along_row_;
    Terms adds;
    for (int i = 0; i < n1_; ++i)
      for (int j = 0; j < n2_; ++j) {
        const auto k = static_cast<std::size_t>(slot(i, j));
        along_row_[k] = along_column_[k] = slot(i, j);
        if (j > 0 && group(i, j) == group(i, j - 1)) {
          along_row_[k] = row_prefix_ + slot(i, j);
          adds.insert(adds.end(), {along_row_[k], along_row_[k - 1], slot(i, j)});
        }
        if (i > 0 && group(i, j) == group(i - 1, j)) {
          along_column_[k] = column_prefix_ + slot(i, j);
          adds.insert(adds.end(), {along_column_[k], along_column_[k - static_cast<std::size_t>(n2_)], slot(i, j)});
        }
      }
    emit_list(3, adds);
  }

  void emit_list(int width, const Terms& list) {
    code_.push_back(static_cast<int>(list.size()) / width);
    code_.insert(code_.end(), list.begin(), list.end());
  }

  void compile_row(int i, bool emit) {
    i_ = i;
    accumulate_.clear(), combine_.clear(), run_on_.clear(), add_.clear(), self_.clear(), multiply_.clear();
    n_combine_ = 0;
    column_slot_.assign(static_cast<std::size_t>(n_groups_ * rows_->offsets() * n2_), kUnset);
    row_slot_.assign(static_cast<std::size_t>(n_groups_ * columns_->offsets() * n2_), kUnset);
    row_far_top_.assign(static_cast<std::size_t>(n_groups_), kNone);
    block_top_.assign(static_cast<std::size_t>(n_groups_ * rows_->offsets()), kNone);
    block_slot_.assign(static_cast<std::size_t>(n_groups_ * rows_->offsets() * n2_), kNone);
    extend_far(emit);
    for (int t1 = 0; t1 < rows_->offsets(); ++t1) {
      const PartnerRange partners = rows_->partners(i, t1);
      if (partners.empty()) continue;
      for (int j = 0; j < n2_; ++j)
        for (int t2 = 0; t2 < columns_->offsets(); ++t2)
          if (!columns_->partners(j, t2).empty()) compile_cell(t1, partners, j, t2);
    }
    emit_list(3, accumulate_);
    code_.push_back(n_combine_);
    code_.insert(code_.end(), combine_.begin(), combine_.end());
    emit_list(4, run_on_);
    emit_list(3, add_);
    emit_products();
    emit_list(3, self_);
  }

  /// Running column sums over the rows that stay in cell i: weighted for every group that will still ask.
  void extend_far(bool emit) {
    const PartnerRange far = rows_->partners(i_, 0);
    const int top = far.empty() || far.first > 0 ? kNone : std::min(far.last, i_ - 1);
    far_here_ = top >= 0 && top >= far_top_;
    while (far_top_ < top) {
      ++far_top_;
      for (int j = 0; j < n2_; ++j)
        for (int c = 0; c < n_groups_; ++c) {
          const auto at = static_cast<std::size_t>(c * n2_ + j);
          if (emit && wanted_until_[at] < i_) continue;
          accumulate_.insert(accumulate_.end(), {far_ + c * n2_ + j, pair(c, group(far_top_, j)), slot(far_top_, j)});
        }
    }
  }

  int combined(int into, const Terms& weights_and_slots) {
    combine_.push_back(into);
    combine_.push_back(static_cast<int>(weights_and_slots.size()) / 2);
    combine_.insert(combine_.end(), weights_and_slots.begin(), weights_and_slots.end());
    ++n_combine_;
    return into;
  }

  /// sum over i' < i in R1(i, t1) of C[c][g(i',j)] Q(i',j); kNone if there are none.
  int column_sum(int c, int t1, int j) {
    int& known = column_slot_[static_cast<std::size_t>((c * rows_->offsets() + t1) * n2_ + j)];
    if (known != kUnset) return known;
    const PartnerRange range = rows_->partners(i_, t1);
    const int last = std::min(range.last, i_ - 1);
    if (range.empty() || range.first > last) return known = kNone;
    if (t1 == 0 && far_here_ && last == far_top_) {
      int& until = wanted_until_[static_cast<std::size_t>(c * n2_ + j)];
      until = std::max(until, i_);
      return known = far_ + c * n2_ + j;
    }
    Terms terms;
    for (int a = range.first; a <= last; ++a) terms.insert(terms.end(), {pair(c, group(a, j)), slot(a, j)});
    return known = combined(column_ + (c * rows_->offsets() + t1) * n2_ + j, terms);
  }

  /// sum over j' < j in R2(j, t2) of C[c][g(i,j')] Q(i,j') along this row.
  int row_sum(int c, int t2, int j) {
    const PartnerRange range = columns_->partners(j, t2);
    const int last = std::min(range.last, j - 1);
    if (range.empty() || range.first > last) return kNone;
    int& top = row_far_top_[static_cast<std::size_t>(c)];
    if (t2 == 0 && range.first == 0 && last >= 0) {
      while (top < last) {
        ++top;
        const int into = row_far_ + c * n2_ + top;
        if (top == 0)
          combined(into, {pair(c, group(i_, 0)), slot(i_, 0)});
        else
          run_on_.insert(run_on_.end(), {into, into - 1, pair(c, group(i_, top)), slot(i_, top)});
      }
      return row_far_ + c * n2_ + last;
    }
    int& known = row_slot_[static_cast<std::size_t>((c * columns_->offsets() + t2) * n2_ + j)];
    if (known != kUnset) return known;
    Terms terms;
    for (int b = range.first; b <= last; ++b) terms.insert(terms.end(), {pair(c, group(i_, b)), slot(i_, b)});
    return known = combined(row_ + (c * columns_->offsets() + t2) * n2_ + j, terms);
  }

  /// sum over j' <= last of column_sum(c, t1, j').
  int block_sum(int c, int t1, int last) {
    int& top = block_top_[static_cast<std::size_t>(c * rows_->offsets() + t1)];
    const int first = (c * rows_->offsets() + t1) * n2_;
    while (top < last) {
      ++top;
      const int more = column_sum(c, t1, top);
      const int before = top > 0 ? block_slot_[static_cast<std::size_t>(first + top - 1)] : kNone;
      int& here = block_slot_[static_cast<std::size_t>(first + top)];
      if (more == kNone || before == kNone) {
        here = more == kNone ? before : more;
      } else {
        here = block_ + first + top;
        add_.insert(add_.end(), {here, before, more});
      }
    }
    return block_slot_[static_cast<std::size_t>(first + last)];
  }

  void multiply(int cell, int unit, Terms sum) {
    if (unit == kNone || sum.empty()) return;
    multiply_[cell].push_back({unit, std::move(sum)});
    ++products_;
  }

  void compile_cell(int t1, PartnerRange partners, int j, int t2) {
    const PartnerRange range = columns_->partners(j, t2);
    const int cell = slot(i_ + t1, j + t2), c = group(i_, j);
    // A: (i,j) dominates.
    Terms sum;
    const auto take = [&](int from) {
      if (from != kNone) sum.push_back(from);
    };
    if (t2 == 0 && range.first == 0) {
      take(block_sum(c, t1, range.last));
    } else {
      for (int b = range.first; b <= range.last; ++b) take(column_sum(c, t1, b));
    }
    if (partners.last == i_) {
      take(row_sum(c, t2, j));
      if (range.last == j) self_.insert(self_.end(), {cell, pair(c, c), slot(i_, j)});
    }
    multiply(cell, slot(i_, j), sum);
    // B: (i, j' < j) with (i' < i, j).
    const int last_row = std::min(partners.last, i_ - 1), last_column = std::min(range.last, j - 1);
    if (partners.first > last_row || range.first > last_column) return;
    if (columns_->pivot(j) <= rows_->pivot(i_)) {
      for (int b = range.first; b <= last_column;) {
        int end = b;
        while (end < last_column && group(i_, end + 1) == group(i_, b)) ++end;
        multiply(cell, column_sum(group(i_, b), t1, j),
                 run_of(b, end, b == 0 || group(i_, b - 1) != group(i_, b), along_row_,
                        [&](int at) { return slot(i_, at); }));
        b = end + 1;
      }
    } else {
      for (int a = partners.first; a <= last_row;) {
        int end = a;
        while (end < last_row && group(end + 1, j) == group(a, j)) ++end;
        multiply(cell, row_sum(group(a, j), t2, j),
                 run_of(a, end, a == 0 || group(a - 1, j) != group(a, j), along_column_,
                        [&](int at) { return slot(at, j); }));
        a = end + 1;
      }
    }
  }

  /// Slots whose sum is that of first .. last of one group: one running sum if the group begins there.
  template <class Slot>
  Terms run_of(int first, int last, bool from_its_start, const Terms& running, Slot slot_at) const {
    if (from_its_start) return {running[static_cast<std::size_t>(slot_at(last))]};
    Terms all;
    for (int at = first; at <= last; ++at) all.push_back(slot_at(at));
    return all;
  }

  void emit_products() {
    code_.push_back(static_cast<int>(multiply_.size()));
    for (const auto& [cell, products] : multiply_) {
      code_.push_back(cell);
      code_.push_back(static_cast<int>(products.size()));
      for (const Product& p : products) {
        code_.push_back(p.unit);
        code_.push_back(static_cast<int>(p.sum.size()));
        code_.insert(code_.end(), p.sum.begin(), p.sum.end());
      }
    }
  }

  const SolidAxis *rows_, *columns_;
  const std::vector<int>* group_;
  int n_groups_, n1_, n2_;
  int row_prefix_ = 0, column_prefix_ = 0, far_ = 0, column_ = 0, row_ = 0, row_far_ = 0, block_ = 0, n_slots_ = 0;
  Terms along_row_, along_column_;  ///< slot of the running sum within a group, by class
  Terms wanted_until_;              ///< last row that asks for a far column sum, shape (groups, columns)
  int far_top_ = kNone;             ///< last row in the far column sums
  bool far_here_ = false;
  int i_ = 0;
  Terms accumulate_, combine_, run_on_, add_, self_;
  int n_combine_ = 0;
  std::map<int, std::vector<Product>> multiply_;  ///< by destination
  Terms column_slot_, row_slot_, row_far_top_, block_top_, block_slot_;
  long products_ = 0;
  std::vector<int> code_;
};

BirthPlan::BirthPlan(const ClassGrid& grid, const std::vector<int>& group, int n_groups) : n_groups_(n_groups) {
  BirthCompiler(grid, group, n_groups).compile(*this);
}

}  // namespace granary::pbm
