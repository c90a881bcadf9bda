#include "dem_templates/render/time_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/units.hpp"
#include "dem_templates/geometry/machine.hpp"
#include "dem_templates/render/feed.hpp"

namespace granary::dem {
namespace {

double smallest_diameter(const DemCase& c) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Population& p : c.population)
    for (std::size_t i = 0; i < p.diameter.size(); ++i)
      if (p.count[i] > 0) smallest = std::min(smallest, p.diameter[i]);
  if (c.feed_rate > 0.0) smallest = std::min(smallest, feed_diameter(c));
  return smallest;
}

}  // namespace

TimeStepFigures time_step_figures(const DemCase& c) {
  TimeStepFigures f;
  f.time_step = c.time_step;
  f.smallest_diameter = smallest_diameter(c);
  f.impact_speed = c.impact_speed > 0.0 ? c.impact_speed : tip_speed(c.machine);
  const double nu = c.contact.poisson_ratio, r = 0.5 * f.smallest_diameter;
  const double shear_modulus = c.contact.young_modulus / (2.0 * (1.0 + nu));
  f.rayleigh_time = kPi * r * std::sqrt(c.density / shear_modulus) / (0.1631 * nu + 0.8766);
  f.rayleigh_share = f.time_step / f.rayleigh_time;
  const double mass = c.density * kPi / 6.0 * std::pow(f.smallest_diameter, 3);
  const double modulus = 1.0 / ((1.0 - nu * nu) * (1.0 / c.contact.young_modulus + 1.0 / c.contact.wall_young_modulus));
  const double v = f.impact_speed;
  f.contact_time = v > 0.0 ? 2.87 * std::pow(mass * mass / (r * modulus * modulus * v), 0.2)
                           : std::numeric_limits<double>::infinity();
  f.contact_share = f.time_step / f.contact_time;
  f.impact_overlap = std::pow(15.0 * mass * v * v / (16.0 * modulus * std::sqrt(r)), 0.4) / r;
  if (c.agglomerates) {
    const Bonds& bonds = c.agglomerates->bonds;
    const double radius = bonds.radius * 0.5 * c.agglomerates->sphere_diameter;
    f.bond_time = std::sqrt(mass / (bonds.normal_stiffness * kPi * radius * radius));
    f.bond_share = f.time_step / f.bond_time;
  }
  return f;
}

double largest_time_step(const TimeStepFigures& f) {
  const double contacts = std::min(kLargestRayleighShare * f.rayleigh_time, kLargestContactShare * f.contact_time);
  return f.bond_time > 0.0 ? std::min(contacts, kLargestBondShare * f.bond_time) : contacts;
}

std::optional<std::string> time_step_problem(const TimeStepFigures& f) {
  if (f.bond_share > kLargestBondShare)
    return fmt::format(
        "{:.3g} s is {:.2f} of the time of a bond, sqrt(m / (S_n A)) = {:.3g} s; at most {:.2f}. It must be at most "
        "{:.3g} "
        "s; softer bonds allow more.",
        f.time_step, f.bond_share, f.bond_time, kLargestBondShare, largest_time_step(f));
  if (f.rayleigh_share <= kLargestRayleighShare && f.contact_share <= kLargestContactShare) return std::nullopt;
  return fmt::format(
      "{:.3g} s is {:.0f} % of the Rayleigh time ({:.3g} s; at most 20 %) and 1/{:.1f} of the contact time of the "
      "fastest impacts ({:.3g} s at {:.3g} m/s; at most 1/15) of the smallest particle ({:.3g} m). It must be at most "
      "{:.3g} s; larger "
      "particles or a lower Young's modulus allow more.",
      f.time_step, 100.0 * f.rayleigh_share, f.rayleigh_time, 1.0 / f.contact_share, f.contact_time, f.impact_speed,
      f.smallest_diameter, largest_time_step(f));
}

std::optional<std::string> overlap_warning(const TimeStepFigures& f, const DemCase& c) {
  const double bound = c.guard.largest_overlap;
  if (f.impact_overlap <= bound) return std::nullopt;
  return fmt::format(
      "a blade at {:.3g} m/s presses a particle in by up to {:.2f} of its radius (elastic), above the guard's bound of "
      "{:.2f}: a "
      "Young's modulus of {:.2g} Pa would keep it below.",
      f.impact_speed, f.impact_overlap, bound, c.contact.young_modulus * std::pow(f.impact_overlap / bound, 2.5));
}

Status check_time_step(const DemCase& c, const std::string& file) {
  if (const auto problem = time_step_problem(time_step_figures(c)))
    return Error{fmt::format("{}: /time_step is too long: {}", file, *problem)};
  return {};
}

}  // namespace granary::dem
