// The population balances that are timed: each with its state to start from.
#pragma once

#include <string>

#include "pbm_solver/time/snapshot.hpp"

namespace granary::pbm::bench {

struct BenchCase {
  PbmCase pbm_case;
  Snapshot start;
};

enum class KernelKind {
  constant,
  classes,  ///< a table between DEM size classes
  stokes    ///< the same times the viscous Stokes efficiency, which depends on both partners' liquid: no structure
};

/// Aggregation in `compartments` on n x n classes that span 16 octaves on each axis, with liquid and gas; every class
/// is populated.
BenchCase operator_case(int bins, int compartments, KernelKind kernel, int n_classes);

/// The same as a run: 16 x 16 classes, 16 compartments, 8 DEM classes, with axial flow from each compartment to the
/// next and feed into the first.
BenchCase row_case();

/// Two solids, constant kernel, exponential start, 16 octaves on each axis, to t = 8, where the degree of aggregation
/// is 0.8; its exact solution is exact::constant_kernel_2d.
BenchCase aggregation_case(int bins, double relative_tolerance);

/// Aggregation at the constant rate 10 against uniform binary breakage at the rate k (v1 + v2)^p, 16 x 16 classes,
/// to T = 8; k is such that the largest class breaks at `largest_rate_times_end` / T.
BenchCase stiff_case(double exponent, double largest_rate_times_end, double relative_tolerance);

/// The published one-way case: the feed of the published codes (15 kg/h in nine classes) into the first of 16
/// compartments, 49 s residence time, spray of 0.35 of the feed's mass from 25 s on, 16 x 16 classes of ratio 3, 100 s;
/// wetness criterion, a table of 16 DEM classes.
BenchCase published_case(double relative_tolerance);

/// sum |a - b| / sum |b| over the numbers of all classes and compartments.
double l1_difference(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace granary::pbm::bench
