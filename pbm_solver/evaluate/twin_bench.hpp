// granary-pbm bench twins: how often the 95 % intervals of each method hold the hidden parameters, and after how many
// evaluations. One thread; the cores at work are imagined (results come in random order, some never).
#pragma once

#include <string>
#include <vector>

#include "common/json/value.hpp"

namespace granary::pbm {

struct TwinBench {
  std::vector<int> parameters{2, 4, 6};
  std::vector<std::string> methods;  ///< empty: all
  int seeds = 20;
  int first_seed = 1;
  int cores = 8;       ///< evaluations in flight
  double lost = 0.02;  ///< share of evaluations that never come back
  long most_evaluations = 3000;
};

/// {"methods": [{name, parameters, seeds, recovered_share (of all parameters' intervals), found_share (of the seeds: a
/// fit at least as good as the truth's), evaluations_median, evaluations_most (to the end of the search),
/// with_intervals_median (to the end), seconds}], ...}
json::Value bench_twins(const TwinBench& bench);

/// {seeds, warned_share, warning}: the twin in which only a product can be found.
json::Value bench_product_twin(const TwinBench& bench);

}  // namespace granary::pbm
