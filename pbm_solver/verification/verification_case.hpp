// A problem whose answer is known: its case on a grid of n classes, what the end of a run is compared with, and the
// bounds the errors must keep. Which problems there are: the functions at the end; running them: verification.hpp.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/model/class_grid.hpp"
#include "pbm_solver/time/snapshot.hpp"

namespace granary::pbm {

/// Relative errors by name: "M00", "M20", "porosity".
using NamedErrors = std::vector<std::pair<std::string, double>>;
json::Value to_json(const NamedErrors& errors);

/// Bounds on the drift of a balance: round-off, more of it where steps solve equations.
inline constexpr double kDriftExplicit = 1e-13, kDriftImplicit = 1e-12;

/// The end of a run held against the exact answer. NaN: the distribution is not known exactly, only its moments.
struct Comparison {
  double l1_number = std::numeric_limits<double>::quiet_NaN();  ///< sum |N - exact| / sum exact, over the cells
  double l1_volume = std::numeric_limits<double>::quiet_NaN();  ///< the same with the solid volume of the cells
  NamedErrors moments;                                          ///< signed
};

/// What the errors on one grid must not exceed.
struct Bound {
  int bins = 0;            ///< classes along each solid that is there
  double l1_number = 0.0;  ///< not looked at where the comparison has none
  NamedErrors moments;     ///< in magnitude; those not named here have the case's bounds
};

struct VerificationCase {
  std::string name;
  std::string group;            ///< a heading of the table, and a panel of the plot
  std::string text;             ///< what is solved, in a line
  std::string reason;           ///< why the bounds are what they are
  std::string order_of = "L1";  ///< what the order is seen in: "L1", a moment, or "" where the grid makes no error
  NamedErrors bounds;           ///< on every grid
  std::vector<Bound> grids;     ///< at least three, coarse to fine
  std::function<PbmCase(int bins)> pbm_case;
  std::function<Comparison(const PbmCase&, const ClassGrid&, const Snapshot& end)> compare;
};

/// The headings, in the table's order.
namespace group {
inline constexpr const char* kOneSolid = "Aggregation, one solid";
inline constexpr const char* kTwoSolids = "Aggregation, two solids";
inline constexpr const char* kBreakage = "Breakage";
inline constexpr const char* kBoth = "Aggregation with breakage or flow";
inline constexpr const char* kTransport = "Flow, porosity and liquid";
}  // namespace group

std::vector<VerificationCase> aggregation_cases();     ///< one solid
std::vector<VerificationCase> aggregation_2d_cases();  ///< two solids
std::vector<VerificationCase> breakage_cases();        ///< alone, with aggregation, and a stirred tank
std::vector<VerificationCase> transport_cases();       ///< a row of tanks, porosity, liquid

/// All of them, in the table's order.
std::vector<VerificationCase> verification_cases();

}  // namespace granary::pbm
