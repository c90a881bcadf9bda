// Compaction of granules: gas squeezed out of the pores.
#pragma once

#include "pbm_solver/case/pbm_case.hpp"

namespace granary::pbm {

/// Gas lost by one granule [m^3/s, >= 0]:
///
///   -dg/dt = c V (1 - eps_min) / s [l_int + g - eps_min / (1 - eps_min) s],    V = s + l_int + g,    l_int = min(phi
///   g, l)
///
/// V is the granule without the liquid outside, so that with l_int fixed its porosity eps = (l_int + g) / V obeys
/// d eps/dt = -c (eps - eps_min) exactly. Nothing is lost at or below eps_min.
/// @param solid, liquid, gas  of the granule [m^3]
/// Source: [iveson1996]; docs/pbm_equations.md#consolidation.
double consolidation_rate(const Consolidation& consolidation, double saturation_factor, double solid, double liquid,
                          double gas);

}  // namespace granary::pbm
