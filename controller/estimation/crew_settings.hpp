// A workflow's section "estimation" as a crew's settings.
#pragma once

#include "controller/campaign/estimation.hpp"
#include "controller/estimation/crew.hpp"

namespace granary::estimating {

/// `dir`: the run directory; `programs`: the folder of granary-pbm.
CrewSettings crew_settings(const campaign::Estimation& estimation, const std::filesystem::path& dir,
                           const std::filesystem::path& programs, int cores);

}  // namespace granary::estimating
