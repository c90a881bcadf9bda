// The share of collisions that stick.
#pragma once

#include <span>

#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/model/active_classes.hpp"
#include "pbm_solver/model/stokes_row.hpp"

namespace granary::pbm {

/// The criterion of these settings.
StokesCriterion stokes_criterion(const Efficiency& efficiency, const Materials& materials,
                                 const SpeedDistribution& speeds);

/// Multiplies beta[q] by the efficiency of p with q, for q = 0 .. beta.size() - 1.
class CollisionEfficiency {
 public:
  CollisionEfficiency(const Efficiency& efficiency, const Materials& materials, const SpeedDistribution& speeds);
  void apply(const ActiveClasses& classes, std::size_t p, std::span<double> beta) const;

 private:
  Efficiency efficiency_;
  StokesCriterion stokes_;
};

}  // namespace granary::pbm
