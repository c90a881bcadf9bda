#include "controller/estimation/crew_settings.hpp"

namespace granary::estimating {

CrewSettings crew_settings(const campaign::Estimation& estimation, const std::filesystem::path& dir,
                           const std::filesystem::path& programs, int cores) {
  CrewSettings settings;
  settings.dir = dir;
  settings.program = programs / "granary-pbm";
  settings.cores = cores;
  for (const estimation::Method method : estimation::kMethods)
    if (estimation::name_of(method) == estimation.method) settings.search.method = method;
  settings.search.seed = static_cast<std::uint64_t>(estimation.seed);
  settings.search.most_evaluations = estimation.most_evaluations;
  return settings;
}

}  // namespace granary::estimating
