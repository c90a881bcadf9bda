// The sums and products that give the births of aggregation on a tensor grid, worked out once per grid: index lists
// that are executed without a branch on the physics, by any width of lanes (simd/).
#pragma once

#include <vector>

#include "pbm_solver/model/class_grid.hpp"

namespace granary::pbm {

/// Births by a kernel that is a table over K size groups, beta(k,m) = C[g_k][g_m], without looking at every pair.
///
/// With Q_k = (F, F s1, F s2, L, G) and a (x) b := a_F b + b_F a (number: a_F b_F), each unordered pair lies in one of
/// two sets:
///
///   A  one dominates in both solids:  E(i+t1, j+t2) += Q(i,j) (x) sum over R1(i,t1) x R2(j,t2) of C[g(i,j)][g_m] Q_m
///   B  each dominates in one:         E(i+t1, j+t2) += Q({i} x R2(j,t2)) (x)_C Q(R1(i,t1) x {j}),   partners < i, < j
///
/// R1(i,t1): the partners of i whose sum falls into cell i + t1, side by side on any rising grid (SolidAxis::partners).
/// So sums over ranges come from running sums (far ranges) and short sums (near ranges): additions of positive numbers
/// only, and the result is that of the double loop to round-off. In B the groups along the side with fewer of them are
/// taken one at a time. About 2 T^2 N^2 products for N x N classes and T offsets, nearly independent of K, against N^4
/// / 2 pairs. A separable kernel is K = 1 with its factors in Q.
///
/// Slots: 0 .. n-1 hold Q by class; the rest is scratch of slots() in all. The code: number of rows; first slot and
/// count of those that start at 0; chains of running sums over Q; then for each row of the grid
///   accumulate  from s: slot[d] += C[c] slot[s] for several d       (n, then s, count, (d, c) ...)
///   scale       from s: slot[d]  = C[c] slot[s] for several d       (the same)
///   combine     slot[d] = sum_n C[c_n] slot[s_n]                    (n, then d, count, (c, s) ...)
///   sum         slot[d] = sum_n slot[s_n]                           (n, then d, count, s ...)
///   run_on      sum += C[c] slot[s]; slot[d] = sum, from 0 on       (n, then count, (c, s, d) ...)
///   add_up      sum = slot[a]; sum += slot[s]; slot[d] = sum        (n, then a, count, (s, d) ...)
///   multiply    E[e] += sum_n slot[u_n] (x) (sum slot[s])           (n, then e, count, (u, count, s ...) ...)
///   self        E[e] += 1/2 C[c] slot[k] (x) slot[k]                (n, then (e, c, k) ...)
/// Running sums are lists, so that they stay in registers.
class BirthPlan {
 public:
  /// @param group    of each class, 0 .. n_groups - 1, shape (n_classes)
  BirthPlan(const ClassGrid& grid, const std::vector<int>& group, int n_groups);

  /// All rows after each other; the layout of simd::run_births.
  const std::vector<int>& code() const { return code_; }
  int slots() const { return n_slots_; }
  int groups() const { return n_groups_; }
  /// Products of the whole plan: the cost.
  long products() const { return n_products_; }

 private:
  friend class BirthCompiler;
  int n_groups_;
  int n_slots_ = 0;
  long n_products_ = 0;
  std::vector<int> code_;
};

}  // namespace granary::pbm
