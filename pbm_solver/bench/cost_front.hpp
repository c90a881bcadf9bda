// What a method costs to reach an error, from runs at various settings.
#pragma once

#include <vector>

namespace granary::pbm::bench {

/// One run: its cost (CPU seconds, right-hand sides) and its error.
struct CostPoint {
  double cost = 0.0;
  double error = 0.0;
};

struct CostAtError {
  double cost = 0.0;
  /// false: no run came down to this error; `cost` is that of the most accurate one, so more would be needed.
  bool reached = true;
};

/// Least cost at an error: on the straight lines, in ln cost over ln error, between the runs that no other beats in
/// both. Nothing is extrapolated: an error above that of the cheapest run costs what that run does.
/// @param points  at least one, costs and errors > 0 (asserted)
CostAtError cost_at_error(std::vector<CostPoint> points, double error);

}  // namespace granary::pbm::bench
