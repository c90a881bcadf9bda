#include "pbm_solver/model/births/birth_plan.hpp"

#include <algorithm>

namespace granary::pbm {
namespace {

constexpr int kNone = -1;
constexpr int kUnset = -2;
constexpr std::size_t kWorthKeeping = 3;  // terms of a sum that is used again

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
    accumulate_.into.resize(static_cast<std::size_t>(n1_ * n2_));
    scale_.into.resize(static_cast<std::size_t>(n1_ * n2_));
    along_row_sums_.resize(static_cast<std::size_t>(n2_ * n2_));
    along_column_sums_.resize(static_cast<std::size_t>(n1_ * n2_));
    for (const bool emit : {false, true}) {
      code_.clear();
      products_ = 0;
      code_.insert(code_.end(), {n1_, far_, n_groups_ * n2_});
      list_column_prefixes();
      far_top_ = kNone;
      emit_ = emit;
      for (int i = 0; i < n1_; ++i) compile_row(i);
    }
    plan.code_ = std::move(code_);
    plan.n_slots_ = n_slots_;
    plan.n_products_ = products_;
  }

 private:
  using Terms = std::vector<int>;
  /// Products that go to one cell: unit, count, slots of the sum ...
  struct Cell {
    int products = 0;
    Terms code;
  };
  /// A slot that is valid while the stamp is the present one.
  struct Stamped {
    int stamp = 0, slot = kNone;
  };
  /// Lists by source slot, of which few are in use.
  struct BySource {
    std::vector<Terms> into;
    Terms used;
    Terms& of(int source) {
      Terms& list = into[static_cast<std::size_t>(source)];
      if (list.empty()) used.push_back(source);
      return list;
    }
    void clear() {
      for (const int source : used) into[static_cast<std::size_t>(source)].clear();
      used.clear();
    }
  };

  int slot(int i, int j) const { return i * n2_ + j; }
  int group(int i, int j) const { return (*group_)[static_cast<std::size_t>(i * n2_ + j)]; }
  int pair(int a, int b) const { return a * n_groups_ + b; }

  void place_slots() {
    const int n = n1_ * n2_;
    column_prefix_ = n;
    far_ = 2 * n;
    first_temporary_ = far_ + n_groups_ * n2_;
    n_slots_ = first_temporary_;
  }

  /// A slot for the rest of this row: rows use the same ones again, which keeps them in the nearest cache.
  int temporary() {
    n_slots_ = std::max(n_slots_, next_temporary_ + 1);
    return next_temporary_++;
  }

  /// Running sums within one group along each column.
  void list_column_prefixes() {
    along_column_.assign(static_cast<std::size_t>(n1_ * n2_), 0);
    std::vector<Terms> chains;
    for (int j = 0; j < n2_; ++j)
      for (int i = 0; i < n1_; ++i) {
        int& here = along_column_[static_cast<std::size_t>(slot(i, j))];
        if (i == 0 || group(i, j) != group(i - 1, j)) {
          here = slot(i, j);
          chains.push_back({here});
        } else {
          here = column_prefix_ + slot(i, j);
          chains.back().insert(chains.back().end(), {slot(i, j), here});
        }
      }
    emit_sums(chains);
  }

  /// Chains of the form (start, (s, d) ...); those of one term need nothing.
  void emit_sums(const std::vector<Terms>& chains) {
    const auto count = code_.size();
    code_.push_back(0);
    for (const Terms& chain : chains) {
      if (chain.size() < 2) continue;
      ++code_[count];
      code_.push_back(chain[0]);
      code_.push_back(static_cast<int>(chain.size() - 1) / 2);
      code_.insert(code_.end(), chain.begin() + 1, chain.end());
    }
  }

  /// By source slot: (d, c) ...
  void emit_by_source(const BySource& list) {
    code_.push_back(static_cast<int>(list.used.size()));
    for (const int source : list.used) {
      const Terms& into = list.into[static_cast<std::size_t>(source)];
      code_.push_back(source);
      code_.push_back(static_cast<int>(into.size()) / 2);
      code_.insert(code_.end(), into.begin(), into.end());
    }
  }

  void emit_list(int width, const Terms& list) {
    code_.push_back(static_cast<int>(list.size()) / width);
    code_.insert(code_.end(), list.begin(), list.end());
  }

  void compile_row(int i) {
    i_ = i;
    accumulate_.clear(), scale_.clear(), combine_.clear(), sum_.clear(), self_.clear();
    n_combine_ = n_sum_ = 0;
    cells_.resize(static_cast<std::size_t>(rows_->offsets() * n2_));
    for (Cell& cell : cells_) cell.products = 0, cell.code.clear();
    ++row_stamp_;
    next_temporary_ = first_temporary_;
    row_run_top_ = kNone;
    along_row_.assign(static_cast<std::size_t>(n2_), kNone);
    row_far_slot_.assign(static_cast<std::size_t>(n_groups_ * n2_), kNone);
    run_on_.assign(static_cast<std::size_t>(n_groups_), {});
    add_up_.assign(static_cast<std::size_t>(n_groups_ * rows_->offsets()), {});
    column_slot_.assign(static_cast<std::size_t>(n_groups_ * rows_->offsets() * n2_), kUnset);
    row_slot_.assign(static_cast<std::size_t>(n_groups_ * columns_->offsets() * n2_), kUnset);
    row_far_top_.assign(static_cast<std::size_t>(n_groups_), kNone);
    block_top_.assign(static_cast<std::size_t>(n_groups_ * rows_->offsets()), kNone);
    block_slot_.assign(static_cast<std::size_t>(n_groups_ * rows_->offsets() * n2_), kNone);
    extend_far();
    for (int t1 = 0; t1 < rows_->offsets(); ++t1) {
      const PartnerRange partners = rows_->partners(i, t1);
      if (partners.empty()) continue;
      for (int j = 0; j < n2_; ++j)
        for (int t2 = 0; t2 < columns_->offsets(); ++t2)
          if (!columns_->partners(j, t2).empty()) compile_cell(t1, partners, j, t2);
    }
    emit_by_source(accumulate_);
    emit_by_source(scale_);
    code_.push_back(n_combine_);
    code_.insert(code_.end(), combine_.begin(), combine_.end());
    code_.push_back(n_sum_);
    code_.insert(code_.end(), sum_.begin(), sum_.end());
    emit_run_on();
    emit_sums(add_up_);
    emit_products();
    emit_list(3, self_);
  }

  /// Running column sums over the rows that stay in cell i: weighted for every group that will still ask.
  void extend_far() {
    const PartnerRange far = rows_->partners(i_, 0);
    const int top = far.empty() || far.first > 0 ? kNone : std::min(far.last, i_ - 1);
    far_here_ = top >= 0 && top >= far_top_;
    while (far_top_ < top) {
      ++far_top_;
      for (int j = 0; j < n2_; ++j)
        for (int c = 0; c < n_groups_; ++c) {
          const auto at = static_cast<std::size_t>(c * n2_ + j);
          if (emit_ && wanted_until_[at] < i_) continue;
          Terms& into = accumulate_.of(slot(far_top_, j));
          into.insert(into.end(), {far_ + c * n2_ + j, pair(c, group(far_top_, j))});
        }
    }
  }

  void emit_run_on() {
    const auto count = code_.size();
    code_.push_back(0);
    for (const Terms& chain : run_on_) {
      if (chain.empty()) continue;
      ++code_[count];
      code_.push_back(static_cast<int>(chain.size()) / 3);
      code_.insert(code_.end(), chain.begin(), chain.end());
    }
  }

  int combined(int into, const Terms& weights_and_slots) {
    if (weights_and_slots.size() == 2) {
      Terms& from = scale_.of(weights_and_slots[1]);
      from.insert(from.end(), {into, weights_and_slots[0]});
      return into;
    }
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
    terms_.clear();
    for (int a = range.first; a <= last; ++a) terms_.insert(terms_.end(), {pair(c, group(a, j)), slot(a, j)});
    return known = combined(temporary(), terms_);
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
        int& here = row_far_slot_[static_cast<std::size_t>(c * n2_ + top)];
        here = temporary();
        Terms& chain = run_on_[static_cast<std::size_t>(c)];
        chain.insert(chain.end(), {pair(c, group(i_, top)), slot(i_, top), here});
      }
      return row_far_slot_[static_cast<std::size_t>(c * n2_ + last)];
    }
    int& known = row_slot_[static_cast<std::size_t>((c * columns_->offsets() + t2) * n2_ + j)];
    if (known != kUnset) return known;
    terms_.clear();
    for (int b = range.first; b <= last; ++b) terms_.insert(terms_.end(), {pair(c, group(i_, b)), slot(i_, b)});
    return known = combined(temporary(), terms_);
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
      Terms& chain = add_up_[static_cast<std::size_t>(c * rows_->offsets() + t1)];
      if (more == kNone) {
        here = before;
      } else if (before == kNone) {
        here = more;
        chain.push_back(more);
      } else {
        here = temporary();
        chain.insert(chain.end(), {more, here});
      }
    }
    return block_slot_[static_cast<std::size_t>(first + last)];
  }

  /// sum of Q(i, j') over the j' <= j side by side that are of its group.
  int row_run(int j) {
    while (row_run_top_ < j) {
      const int at = ++row_run_top_;
      int& here = along_row_[static_cast<std::size_t>(at)];
      if (at == 0 || group(i_, at) != group(i_, at - 1)) {
        here = slot(i_, at);
        add_up_.push_back({here});
      } else {
        here = temporary();
        add_up_.back().insert(add_up_.back().end(), {slot(i_, at), here});
      }
    }
    return along_row_[static_cast<std::size_t>(j)];
  }

  void multiply(int t1, int column, int unit, const Terms& sum) {
    if (unit == kNone || sum.empty()) return;
    ++products_;
    if (!emit_) return;
    Cell& cell = cells_[static_cast<std::size_t>(t1 * n2_ + column)];
    ++cell.products;
    cell.code.push_back(unit);
    cell.code.push_back(static_cast<int>(sum.size()));
    cell.code.insert(cell.code.end(), sum.begin(), sum.end());
  }

  void compile_cell(int t1, PartnerRange partners, int j, int t2) {
    const PartnerRange range = columns_->partners(j, t2);
    const int c = group(i_, j);
    // A: (i,j) dominates.
    factor_.clear();
    const auto take = [&](int from) {
      if (from != kNone) factor_.push_back(from);
    };
    if (t2 == 0 && range.first == 0) {
      take(block_sum(c, t1, range.last));
    } else {
      for (int b = range.first; b <= range.last; ++b) take(column_sum(c, t1, b));
    }
    if (partners.last == i_) {
      take(row_sum(c, t2, j));
      if (range.last == j) self_.insert(self_.end(), {slot(i_ + t1, j + t2), pair(c, c), slot(i_, j)});
    }
    multiply(t1, j + t2, slot(i_, j), factor_);
    // B: (i, j' < j) with (i' < i, j), one group at a time along the side that has fewer.
    const int last_row = std::min(partners.last, i_ - 1), last_column = std::min(range.last, j - 1);
    if (partners.first > last_row || range.first > last_column) return;
    if (columns_->pivot(j) <= rows_->pivot(i_)) {
      for (int b = range.first, end; b <= last_column; b = end + 1) {
        for (end = b; end < last_column && group(i_, end + 1) == group(i_, b);) ++end;
        multiply(t1, j + t2, column_sum(group(i_, b), t1, j), sum_along_row(b, end));
      }
    } else {
      for (int a = partners.first, end; a <= last_row; a = end + 1) {
        for (end = a; end < last_row && group(end + 1, j) == group(a, j);) ++end;
        multiply(t1, j + t2, row_sum(group(a, j), t2, j), sum_along_column(a, end, j));
      }
    }
  }

  /// Slots whose sum is that of Q(i, first .. last), all of one group.
  const Terms& sum_along_row(int first, int last) {
    if (first == 0 || group(i_, first - 1) != group(i_, first)) return one(row_run(last));
    return summed(first, last, along_row_sums_[static_cast<std::size_t>(first * n2_ + last)],
                  [&](int at) { return slot(i_, at); });
  }
  const Terms& sum_along_column(int first, int last, int j) {
    if (first == 0 || group(first - 1, j) != group(first, j))
      return one(along_column_[static_cast<std::size_t>(slot(last, j))]);
    return summed(first, last, along_column_sums_[static_cast<std::size_t>(first * n2_ + j)],
                  [&](int at) { return slot(at, j); });
  }
  const Terms& one(int slot_of_sum) {
    factor_.assign(1, slot_of_sum);
    return factor_;
  }
  /// Long sums are needed for several offsets: once a row is enough.
  template <class Slot>
  const Terms& summed(int first, int last, Stamped& known, Slot slot_at) {
    factor_.clear();
    for (int at = first; at <= last; ++at) factor_.push_back(slot_at(at));
    if (factor_.size() < kWorthKeeping) return factor_;
    if (known.stamp != row_stamp_) {
      known = {row_stamp_, temporary()};
      sum_.push_back(known.slot);
      sum_.push_back(static_cast<int>(factor_.size()));
      sum_.insert(sum_.end(), factor_.begin(), factor_.end());
      ++n_sum_;
    }
    return one(known.slot);
  }

  void emit_products() {
    const auto count = code_.size();
    code_.push_back(0);
    for (std::size_t at = 0; at < cells_.size(); ++at) {
      const Cell& cell = cells_[at];
      if (cell.products == 0) continue;
      ++code_[count];
      code_.push_back(i_ * n2_ + static_cast<int>(at));
      code_.push_back(cell.products);
      code_.insert(code_.end(), cell.code.begin(), cell.code.end());
    }
  }

  const SolidAxis *rows_, *columns_;
  const std::vector<int>* group_;
  int n_groups_, n1_, n2_;
  int column_prefix_ = 0, far_ = 0, first_temporary_ = 0, next_temporary_ = 0, n_slots_ = 0;
  Terms along_column_;              ///< slot of the running sum within a group, by class
  Terms along_row_, row_far_slot_;  ///< of this row: the same; and the running sums for each group
  int row_run_top_ = kNone;
  Terms wanted_until_;   ///< last row that asks for a far column sum, shape (groups, columns)
  int far_top_ = kNone;  ///< last row in the far column sums
  bool far_here_ = false;
  int i_ = 0;
  bool emit_ = false;
  BySource accumulate_, scale_;
  Terms combine_, sum_, self_;
  int n_sum_ = 0;
  std::vector<Cell> cells_;  ///< of the rows i .. i + offsets - 1
  int row_stamp_ = 0;
  std::vector<Stamped> along_row_sums_, along_column_sums_;  ///< by first and last; by first and column
  Terms terms_, factor_;                                     ///< working space
  std::vector<Terms> run_on_, add_up_;                       ///< chains
  int n_combine_ = 0;
  Terms column_slot_, row_slot_, row_far_top_, block_top_, block_slot_;
  long products_ = 0;
  std::vector<int> code_;
};

BirthPlan::BirthPlan(const ClassGrid& grid, const std::vector<int>& group, int n_groups) : n_groups_(n_groups) {
  BirthCompiler(grid, group, n_groups).compile(*this);
}

}  // namespace granary::pbm
