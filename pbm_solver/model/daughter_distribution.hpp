// What a broken particle becomes: two fragments, always; both solids, liquid and gas of the parent are in them.
#pragma once

#include <span>
#include <vector>

#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/model/cell_average.hpp"
#include "pbm_solver/model/class_grid.hpp"

namespace granary::pbm {

/// Births from breaking parents, per class: how many break and what liquid and gas they hold.
struct Broken {
  std::vector<double> number;  ///< [1/s]
  std::vector<double> liquid;  ///< [m^3/s]
  std::vector<double> gas;     ///< [m^3/s]
};

/// Fragments of a parent with solids (x1, x2) are (u1, u2) and (x1 - u1, x2 - u2):
///
///   uniform_binary     u_k uniform in [0, x_k], independent:  b = 2 / (x1 x2)
///   halves             u_k = x_k / 2
///   same_composition   u_k = theta x_k, theta uniform in [0, 1]
///
/// integrated exactly over the grid's cells. Nothing is smaller than the first pivot p_k of a solid that is there: u_k
/// is held within [p_k, x_k - p_k] (theta likewise), which moves material between sisters and loses none; a parent with
/// x_k < 2 p_k of a solid cannot be divided. Liquid and gas are divided as the solid volume is.
class DaughterDistribution {
 public:
  DaughterDistribution(const ClassGrid& grid, Breakage::Daughters model);

  /// Whether particles of a class can break on this grid.
  bool divisible(std::size_t k) const { return divisible_[k]; }
  /// Adds the fragments of all that break; parents that are not divisible must be 0.
  /// Cost: O(n_1 n_2 (n_1 + n_2)) for uniform_binary, O(fragments) else.
  void add_births(const ClassGrid& grid, const Broken& broken, BirthGrid& births) const;

 private:
  /// One solid's uniform fragments: from parent i into cell a, their share and their mean volume times their share.
  struct AxisFragments {
    std::vector<double> share;   ///< shape (n, n), row: parent
    std::vector<double> volume;  ///< [m^3], shape (n, n)
  };
  struct Fragment {
    int i, j;                         ///< cell
    double number, solid_1, solid_2;  ///< per broken parent
  };
  static AxisFragments uniform_on(const SolidAxis& axis);
  void list_fragments(const ClassGrid& grid, Breakage::Daughters model);
  void add_uniform(const ClassGrid& grid, const Broken& broken, BirthGrid& births) const;
  void add_listed(const ClassGrid& grid, const Broken& broken, BirthGrid& births) const;

  Breakage::Daughters model_;
  std::vector<char> divisible_;
  AxisFragments rows_, columns_;     ///< uniform_binary
  std::vector<Fragment> fragments_;  ///< the other models: those of class k are [first_[k], first_[k + 1])
  std::vector<std::size_t> first_;
};

}  // namespace granary::pbm
