// Births and deaths by aggregation in one compartment, over every unordered pair of classes.
#pragma once

#include <vector>

#include "pbm_solver/model/active_classes.hpp"
#include "pbm_solver/model/aggregation_kernel.hpp"
#include "pbm_solver/model/cell_average.hpp"

namespace granary::pbm {

/// With Q_k = (F, F s1, F s2, L, G) of class k, and each unordered pair once (1/2 for a class with itself):
///
///   birth_Q += beta_kl (Q_k F_l + F_k Q_l), number: beta_kl F_k F_l,   in cell (d1(i,i'), d2(j,j'))
///   death_k += beta_kl F_l,   death_l += beta_kl F_k                    [1/s] per particle
///
/// The destination d1 comes from two tables of n1^2 and n2^2 entries, never from a search.
/// The pairs are cut into kParts parts whose borders depend on the state alone; each part has its own sums, added in
/// their order. So the result has the same bits however many threads share the parts.
class Aggregation2d {
 public:
  static constexpr int kParts = 8;

  explicit Aggregation2d(const ClassGrid& grid);

  /// Sums of one part; parts may run at the same time.
  void run_part(int part, const AggregationKernel& kernel, const ActiveClasses& classes);
  /// Births of all parts, added to `births`; death rate per particle by active class [1/s].
  void collect(const ActiveClasses& classes, BirthGrid& births, std::vector<double>& death) const;

 private:
  struct Part {
    BirthGrid births;
    std::vector<double> death;  ///< by active class [1/s]
    std::vector<double> beta;   ///< of one class with those before it
  };
  void add_pairs_of(std::size_t p, const ActiveClasses& classes, Part& sums) const;

  const ClassGrid* grid_;
  std::vector<Part> parts_;
};

}  // namespace granary::pbm
