// What all compartments of a case share, worked out once: grid, index lists, fragments. Absent mechanisms are absent
// here too.
#pragma once

#include <array>
#include <optional>

#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/model/aggregation_operator.hpp"
#include "pbm_solver/model/breakage_operator.hpp"
#include "pbm_solver/model/class_grid.hpp"

namespace granary::pbm {

/// What came into the whole row and left it through one compartment since the start: the book-keeping of conservation.
/// [m^3]; for each of solid 1, solid 2, liquid, gas.
namespace ledger {
enum : std::size_t {
  kStart = 0,            ///< held at the very start
  kIn = 4,               ///< fed and sprayed
  kOut = 8,              ///< left at the end of the row
  kOversize = 12,        ///< left above the grid's last pivots
  kConsolidated = 16,    ///< gas squeezed out
  kOversizeNumber = 17,  ///< particles above the grid [-]
  kSize = 18
};
}  // namespace ledger

/// The state of one compartment, shape (n_classes) each.
struct Fields {
  std::span<const double> number;  ///< particles [-]
  std::span<const double> liquid;  ///< total liquid of the class [m^3]
  std::span<const double> gas;     ///< total gas of the class [m^3]
};

/// Volume of solid 1, solid 2, liquid and gas in one compartment [m^3].
std::array<double, 4> holdup(const ClassGrid& grid, Fields state);

/// Which inputs are on during a step: the steps end at every switch.
struct Inputs {
  bool feed = false;
  bool spray = false;
};
Inputs inputs_at(const PbmCase& pbm_case, double time);

struct ModelTables {
  explicit ModelTables(const PbmCase& pbm_case);
  // Blocks hold pointers into it.
  ModelTables(const ModelTables&) = delete;
  ModelTables& operator=(const ModelTables&) = delete;

  PbmCase pbm_case;
  ClassGrid grid;
  int lanes;
  simd::GridView view;
  SolidLanes solids;
  std::optional<AggregationTables> aggregation;
  std::optional<Fragments> fragments;
};

}  // namespace granary::pbm
