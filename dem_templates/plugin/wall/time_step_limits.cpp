#include "dem_templates/plugin/wall/time_step_limits.hpp"

#include <fmt/format.h>

#include <cmath>

namespace granary::dem {

double hertz_contact_time(double effective_young, double radius, double mass, double speed) {
  const double deepest = std::pow(15.0 / 16.0 * mass * speed * speed / (effective_young * std::sqrt(radius)), 0.4);
  return 2.94 * deepest / speed;
}

std::string time_step_problems(const WallBody& body, double smallest_radius, double shortest_contact,
                               double time_step) {
  constexpr double kFewest = 8.0, kGood = 20.0;  // steps of a contact
  std::string problems;
  const double way = body.tip_speed() * time_step;
  if (way > 0.5 * smallest_radius)
    problems += fmt::format(
        "\n  body '{}' goes {:.3g} m a step at its tip; at most half the smallest particle's radius ({:.3g} m) lets no "
        "particle slip through. Take a time step below {:.3g} s.",
        body.name, way, 0.5 * smallest_radius, 0.5 * smallest_radius / way * time_step);
  if (time_step > shortest_contact / kFewest)
    problems += fmt::format(
        "\n  body '{}': the shortest contact lasts {:.3g} s by its stiffness and the speeds there are, {:.3g} time "
        "steps. Take a time step below {:.3g} s, or a softer material.",
        body.name, shortest_contact, shortest_contact / time_step, shortest_contact / kGood);
  return problems;
}

}  // namespace granary::dem
