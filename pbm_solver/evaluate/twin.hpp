// Twin experiments: problems whose answer is known, since the data are the solver's own at hidden parameters, with
// noise. Cheap ones: two batch granulations (wetter and slower, drier and faster) of 6 x 6 classes.
#pragma once

#include <cstdint>
#include <vector>

#include "estimation/problem/problem.hpp"

namespace granary::pbm {

struct Twin {
  estimation::Problem problem;
  std::vector<double> truth;  ///< hidden values of the parameters
};

/// Fitted: d10, d50, d90, number (errors of 5 %) and porosity (0.01) at 5, 10, 20 and 40 s of both experiments, 40
/// data; held out: the same at 30 s. The truth lies anywhere in the middle 30 % of each parameter's bounds.
/// @param n_parameters  2, 4 or 6: rates of aggregation and breakage; of consolidation, strength; roughness, least
///                      porosity
Twin make_twin(int n_parameters, std::uint64_t seed);

/// One in which rate and efficiency of aggregation are both looked for: only their product can be found.
Twin make_product_twin(std::uint64_t seed);

}  // namespace granary::pbm
