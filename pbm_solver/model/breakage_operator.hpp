// Breakage in one block of compartments as a linear map of what each class holds: added to the rates, or solved for.
#pragma once

#include <vector>

#include "pbm_solver/model/class_grid.hpp"
#include "pbm_solver/model/simd/operations.hpp"

namespace granary::pbm {

/// Fragments of a parent with solids (x1, x2) are (u1, u2) and (x1 - u1, x2 - u2):
///
///   uniform_binary     u_k uniform in [0, x_k], independent:  b = 2 / (x1 x2)
///   halves             u_k = x_k / 2
///   same_composition   u_k = theta x_k, theta uniform in [0, 1]
///   table              any number of fragments z x, each with the share z of either solid; between two parents of the
///                      table the mean of both, linear in ln of the solid volume. What would be smaller than p_k is put
///                      together in fewer fragments of that size.
///
/// integrated exactly over the grid's cells; each cell's share goes to the pivots around its mean (cell average, parent
/// by parent), so that number and both solids survive. Nothing is smaller than the first pivot p_k of a solid that is
/// there: u_k is held within [p_k, x_k - p_k] (theta likewise), which moves material between sisters and loses none; a
/// parent with x_k < 2 p_k of a solid cannot be divided.
///
/// Liquid and gas are divided as the solid volume is: L / s and G / s follow the same map as the number. The map leads
/// from a class to classes that are no larger in either solid: it is triangular, and (1 - gamma A) is inverted by
/// substitution.
class Fragments {
 public:
  /// `table` is read by the model of that name.
  Fragments(const ClassGrid& grid, Breakage::Daughters model, const BreakageTable& table = {});

  bool divisible(std::size_t k) const { return divisible_[k]; }
  /// Particles of class `to` per broken particle of class `parent`.
  double weight(std::size_t to, std::size_t parent) const;
  simd::FragmentView view() const;

 private:
  void list_uniform(const SolidAxis& axis, std::vector<double>& along) const;
  void list_fragments(const ClassGrid& grid, Breakage::Daughters model, const BreakageTable& table);

  int n1_, n2_;
  bool products_;
  std::vector<char> divisible_;
  std::vector<double> along_1_, along_2_;  ///< [pivot][parent]
  std::vector<int> first_, to_;
  std::vector<double> weight_, diagonal_;
};

}  // namespace granary::pbm
