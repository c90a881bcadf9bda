// The usual kind of exact problem: a distribution known at all times, in one compartment of 1 m^3, with unit rates.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pbm_solver/verification/cell_content.hpp"
#include "pbm_solver/verification/verification_case.hpp"

namespace granary::pbm {

/// sum over particles of x^p y^q, named "Mpq".
struct Moment {
  int p = 0, q = 0;
  double exact = 0.0;  ///< at the end
  double start = 1.0;  ///< needed with `number_start`
};

struct DensityProblem {
  std::string name, group, text;
  std::function<Grid(int bins)> grid;
  std::optional<Aggregation> aggregation;
  std::optional<Breakage> breakage;
  double end = 1.0;  ///< [s]
  /// What the exact distribution holds in each cell at a time; with `moments_only` only at the start.
  std::function<BirthGrid(const ClassGrid&, double t)> content;
  bool moments_only = false;
  std::vector<Moment> moments{};
  /// Given: one stirred tank of this turnover [1/s] starts empty and is fed with what would be the start.
  std::optional<double> turnover{};
  /// The start keeps the number of each cell on its own pivot, not its solids too: they are off by up to some percent
  /// then. So published figures were made; moments are compared by their growth since the start.
  bool number_start = false;
  /// Cells below this are one cell to the comparison: particles with so little of a solid count as without it.
  double merged_below = 0.0;
};

/// The number is the time steps' error alone: twice their tolerance. What lies below the first pivot is put on it, what
/// lies above the last is lost: together less than 1e-5 of the solids on the grids used here.
inline const NamedErrors kUsualBounds{{"M00", 2e-5}, {"M10", 1e-5}, {"M01", 1e-5}};

/// Bins whose edges go evenly in the logarithm from `smallest` to `largest`.
std::function<Grid(int bins)> even_edges(double smallest, double largest, bool two_solids);

/// Where the bounds of a case come from.
inline constexpr const char* kPlain =
    "the figures of a plain cell average code with Dormand-Prince steps on the same grid";
inline constexpr const char* kOurs = "what this scheme gave when the case was written, and a tenth";

VerificationCase make_case(DensityProblem problem, std::string reason, std::vector<Bound> grids,
                           NamedErrors bounds = kUsualBounds);

}  // namespace granary::pbm
