// The same machine with our walls and with LIGGGHTS' own, or another step: do collisions, impacts and velocities agree
// within chance?
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "controller/bench/dem_speed.hpp"
#include "controller/bench/estimate.hpp"
#include "dem_templates/case/dem_case.hpp"

namespace granary::bench {

/// What two cases measure; a window of the tally is a batch.
struct Comparison {
  std::vector<Difference> all;
  /// Degrees of freedom of the errors: batches less those whose means they are taken from, of both.
  std::size_t freedom() const;
  /// What |z| chance alone exceeds in one comparison out of 1/p, over all its quantities.
  double allowed_z(double p) const { return largest_z(all.size(), freedom(), p); }
  const Difference& worst() const;
};

/// Two cases, so many seeds each, as many at once as there are cores.
/// @param only  names of the quantities to keep; empty: all
/// Errors: granary-dem fails.
Result<Comparison> compare(const dem::DemCase& a, const dem::DemCase& b, int seeds,
                           const std::filesystem::path& scratch, const std::vector<std::string>& only = {});
/// The same case with stock walls (a) and with ours (b).
Result<Comparison> compare_walls(const dem::DemCase& dem_case, int seeds, const std::filesystem::path& scratch,
                                 const std::vector<std::string>& only = {});

/// rows of comparison[]: the mixer at work, the batch bowl, and the ten seconds' mixer with its long steps.
Result<json::Value> comparison_rows(Effort effort, const std::filesystem::path& scratch, const Say& say);

}  // namespace granary::bench
