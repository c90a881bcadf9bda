#include "pbm_solver/model/consolidation.hpp"

#include <algorithm>

namespace granary::pbm {

double consolidation_rate(const Consolidation& consolidation, double saturation_factor, double solid, double liquid,
                          double gas) {
  const double least = consolidation.least_porosity;
  const double pores = std::min(saturation_factor * gas, liquid) + gas;
  const double excess = pores - least / (1.0 - least) * solid;
  return std::max(0.0, consolidation.rate * (solid + pores) * (1.0 - least) / solid * excess);
}

}  // namespace granary::pbm
