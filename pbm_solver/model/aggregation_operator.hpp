// Births and deaths by aggregation in one block of compartments, in the form that suits the kernel.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "pbm_solver/model/births/birth_plan.hpp"
#include "pbm_solver/model/births/pair_list.hpp"
#include "pbm_solver/model/cross_approximation.hpp"
#include "pbm_solver/model/pair_kernel.hpp"
#include "pbm_solver/model/particles.hpp"
#include "pbm_solver/model/simd/operations.hpp"

namespace granary::pbm {

/// What all blocks of a case share: which form, and its index lists.
///
/// | form      | kernels                                                        | exact |
/// |-----------|----------------------------------------------------------------|-------|
/// | groups    | constant; a rate table looked up by group                      | yes   |
/// | factors   | sum, product, shear: sums of f g' + g f'                       | yes   |
/// | pairs     | any other, every pair from a table of beta                     | yes   |
/// | low_rank  | any other whose table would be larger than kLargestTable       | to kernel_tolerance |
///
/// `wet` efficiencies are a factor 0 or 1 on each particle and fit every form; `stokes` needs pairs or low_rank.
struct AggregationTables {
  enum class Form { groups, factors, pairs, low_rank };
  /// Of the table of beta in all blocks [bytes]. Measured: up to there reading it costs less than the terms of a
  /// low-rank form.
  static constexpr double kLargestTable = 2e9;

  AggregationTables(const PbmCase& pbm_case, const ClassGrid& grid);

  Form form;
  std::vector<int> group;  ///< of each class
  int n_groups = 1;
  std::optional<BirthPlan> plan;  ///< all but pairs
  std::optional<PairList> pairs;  ///< pairs
  std::vector<int> top_1, top_2, top_of_1, top_of_2;
  simd::GroupView groups() const;
};

/// The group of each class for a rate table looked up by group: the size class whose centre is nearest in ln d to the
/// class's dry particle with the feed's pores.
std::vector<int> size_groups(const PbmCase& pbm_case, const ClassGrid& grid, const std::vector<double>& diameter);

/// State of one block, [class][lanes] each.
struct BlockFields {
  const double* number;
  const double* liquid;
  const double* gas;
};
struct BlockRates {
  double* number;
  double* liquid;
  double* gas;
};

class AggregationOperator {
 public:
  /// Compartments first .. first + count - 1 in the lanes of one block.
  AggregationOperator(const AggregationTables& tables, const PbmCase& pbm_case, const ClassGrid& grid,
                      const simd::GridView& view, int first, int count, int lanes);

  /// Whether the kernel depends on liquid and gas: then refresh() belongs to every change that matters.
  bool looks_at_particles() const;
  /// Whether that dependence is so cheap that it is followed in every evaluation.
  bool follows_particles() const { return tables_->form == AggregationTables::Form::factors; }
  /// Works the kernel out again for these particles.
  void refresh(const ParticleTable& particles);
  /// Which classes are wet from now on (efficiency `wet`): [class][lanes] of 0 and 1.
  void set_wet(const LaneVector& wet) { wet_ = wet; }

  /// births += what is born [class] packs; rates -= what is lost; loss += loss rate per particle [class][lanes] [1/s];
  /// above += the moments of what lands above the grid, one pack. participation: factor on each class, or null.
  void add(BlockFields state, const double* participation, double* births, BlockRates rates, double* loss,
           double* above);
  /// Terms of the low-rank form; 0 otherwise.
  std::size_t rank() const { return plus_.size() + minus_.size(); }
  /// Largest error of the low-rank form over the collision rate; 0 for the exact forms.
  double kernel_error() const { return kernel_error_; }

 private:
  struct Factors {
    LaneVector f, g;  ///< g empty: the same as f
  };
  void approximate_lanes(const ParticleTable& particles);
  void list_factors(const ParticleTable& particles);
  void add_low_rank(BlockFields state, const double* participation, double* births, BlockRates rates, double* loss,
                    double* above);
  void add_factors(const LaneVector& f, const LaneVector& g, BlockFields state, const double* participation,
                   double sign, double* births, BlockRates rates, double* loss, double* above);
  const double* weights(const double* participation, const LaneVector* factor, LaneVector& into) const;
  void take_away(const double* weight, const LaneVector* factor, double sign, BlockFields state, BlockRates rates,
                 double* loss);

  const AggregationTables* tables_;
  const simd::Operations* do_;
  simd::GridView grid_;
  Aggregation::Kernel kernel_kind_;
  bool by_particles_;
  double tolerance_, reference_volume_, efficiency_;
  std::size_t n_, lanes_;
  PairKernel kernel_;
  LaneVector wet_;          ///< empty: all
  LaneVector coefficient_;  ///< groups: C [1/s], shape (groups^2, lanes)
  std::vector<Factors> factors_;
  LaneVector beta_, row_;                 ///< pairs: [pair][lanes]; one row of them
  std::vector<PairKernel> single_;        ///< low_rank: the kernel of each lane by itself
  std::vector<LaneVector> plus_, minus_;  ///< low_rank: factors, [class][lanes]
  double kernel_error_ = 0.0;
  std::span<const double> solid_;
  LaneVector slots_, other_slots_, weight_, other_weight_, death_, scratch_, minus_births_;
};

}  // namespace granary::pbm
