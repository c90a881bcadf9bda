// The errors against the number of classes, a line for each case, drawn by gnuplot.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "common/result.hpp"
#include "pbm_solver/verification/verification.hpp"

namespace granary::pbm {

/// gnuplot's input: a panel for each group whose cases have an order, both axes logarithmic, with the mean order of
/// each line in the key and slopes 1 and 2 as guides.
std::string convergence_script(std::span<const Verification> results);

/// Errors: no case was run on two grids or more; gnuplot is not there (says which package has it) or fails; a file that
/// cannot be written.
Status write_convergence_plot(std::span<const Verification> results, const std::filesystem::path& svg);

}  // namespace granary::pbm
