// A population balance with the fitted kernel beside the DEM it came from, or beside one that was held out.
#pragma once

#include <filesystem>
#include <vector>

#include "common/result.hpp"
#include "controller/sweep/kernel.hpp"

namespace granary::sweep {

/// d50 by volume of both, at the same times and by the same classes.
struct Comparison {
  std::string name;                            ///< of the case
  std::vector<double> time;                    ///< [s], shape (T)
  std::vector<double> dem_d50, pbm_d50;        ///< [m], shape (T)
  std::vector<double> dem_number, pbm_number;  ///< fragments, shape (T)
  double mean_error() const;                   ///< mean of |PBM / DEM - 1| over the times after the first
  double last_error() const;                   ///< PBM / DEM - 1 at the last
};

/// The case of the balance: one compartment that begins with the fragments of the first sample. `bins` classes from one
/// sphere to the whole agglomerate.
pbm::PbmCase balance_of(const BreakageKernel& kernel, const ResolvedCase& one, int bins = 36);

/// Runs granary-pbm in `folder` and compares. Errors: it failed; its file cannot be read.
Result<Comparison> compare(const BreakageKernel& kernel, const ResolvedCase& one, const std::filesystem::path& folder,
                           const std::filesystem::path& programs);

}  // namespace granary::sweep
