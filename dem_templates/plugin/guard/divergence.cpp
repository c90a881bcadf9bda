#include "dem_templates/plugin/guard/divergence.hpp"

#include <fmt/format.h>

#include <limits>

namespace granary::dem {

std::optional<Divergence> find_divergence(const Vitals& vitals, const Bounds& bounds) {
  if (!vitals.finite)
    return Divergence{"nan",
                      std::numeric_limits<double>::quiet_NaN(),
                      0.0,
                      "positions or velocities are no longer numbers. The time step is far too long for the contacts.",
                      {"/dem/time_step", "/materials/contact/young_modulus"}};
  // One may be pinched between a blade and the casing without harm to the rest.
  const double overlapping =
      vitals.present > 0 ? static_cast<double>(vitals.overlapping) / static_cast<double>(vitals.present) : 0.0;
  if (vitals.overlapping > 1 && overlapping > bounds.overlapping_fraction)
    return Divergence{
        "overlap",
        overlapping,
        bounds.overlapping_fraction,
        fmt::format("{} of {} particles ({:.3g}) overlap by more than {:.3g} of their radius, the largest "
                    "overlap is {:.3g}; at most {:.3g} of them may. Shorten the time step, or make the "
                    "particles stiffer, or fill the machine less.",
                    vitals.overlapping, vitals.present, overlapping, bounds.overlap, vitals.overlap,
                    bounds.overlapping_fraction),
        {"/dem/time_step", "/materials/contact/young_modulus", "/dem/guard/largest_overlap"}};
  if (bounds.energy && vitals.energy > *bounds.energy)
    return Divergence{"energy",
                      vitals.energy,
                      *bounds.energy,
                      fmt::format("the particles' kinetic energy is {:.3g} J; at most {:.3g} J is allowed. Shorten the "
                                  "time step, or check the "
                                  "speed of the moving walls.",
                                  vitals.energy, *bounds.energy),
                      {"/dem/time_step", "/dem/machine/impeller_speed", "/dem/guard/energy_factor"}};
  const double lost =
      vitals.ever_present > 0 ? static_cast<double>(vitals.lost) / static_cast<double>(vitals.ever_present) : 0.0;
  if (lost > bounds.lost_fraction)
    return Divergence{"lost",
                      lost,
                      bounds.lost_fraction,
                      fmt::format("{} of {} particles are gone and did not leave through an outlet: {:.3g} of them, at "
                                  "most {:.3g} is allowed. "
                                  "Shorten the time step, or close the holes of the walls.",
                                  vitals.lost, vitals.ever_present, lost, bounds.lost_fraction),
                      {"/dem/time_step", "/dem/machine", "/dem/guard/lost_fraction"}};
  return std::nullopt;
}

json::Value divergence_line(const Divergence& divergence, double time) {
  return json::Value::object({{"diverged", json::Value::object({{"cause", divergence.cause},
                                                                {"value", divergence.value},
                                                                {"bound", divergence.bound},
                                                                {"time_s", time},
                                                                {"message", divergence.message},
                                                                {"settings", divergence.settings}})}});
}

}  // namespace granary::dem
