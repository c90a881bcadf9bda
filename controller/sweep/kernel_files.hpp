// What `granary kernel` leaves: the law, a kernel file for each case, the comparison as a table and as a picture.
#pragma once

#include <filesystem>
#include <vector>

#include "common/result.hpp"
#include "controller/sweep/kernel.hpp"
#include "controller/sweep/kernel_check.hpp"

namespace granary::sweep {

/// kernel.json, 0001.json ..., comparison.csv and d50.svg in `folder`. Errors: a full disk, no gnuplot.
Status write_kernel(const BreakageKernel& kernel, const std::vector<ResolvedCase>& cases,
                    const std::vector<Comparison>& comparisons, const std::filesystem::path& folder);

/// A line a case: settings, fitted or held out, d50 at the end of both, errors.
std::string comparison_csv(const std::vector<ResolvedCase>& cases, const std::vector<Comparison>& comparisons);

}  // namespace granary::sweep
