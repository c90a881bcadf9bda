#include "dem_templates/render/regions.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem_templates/geometry/horizontal_mixer.hpp"
#include "dem_templates/render/feed.hpp"
#include "dem_templates/render/render.hpp"
#include "dem_templates/templates.hpp"

namespace granary::dem {
namespace {

constexpr double kPastTheWall = 0.005;  // what is so far outside of the casing has left [m]

std::string mixer_space(const HorizontalMixer& m) {
  return fmt::format(
      "region casing cone x 0 0 {} {} 0 {} units box\n"
      "region off_shaft cylinder x 0 0 {} -1 {} side out units box\n"
      "region space intersect 2 casing off_shaft",
      0.5 * m.inlet_diameter, 0.5 * m.outlet_diameter, m.length, 0.5 * m.shaft_diameter, m.shaft_length);
}

// Hub and chopper shaft are hollow to the triangles' eye: keep their insides out.
std::string bowl_space(const BatchBowl& b) {
  const double low = 0.5 * b.bottom_diameter, high = 0.5 * b.cover_diameter;
  const BowlShafts shafts = bowl_shafts(b);
  return fmt::format(
      "region bowl cylinder z 0 0 {low} 0 {h1} units box\n"
      "region cone cone z 0 0 {low} {high} {h1} {h2} units box\n"
      "region neck cylinder z 0 0 {high} {h2} {h3} units box\n"
      "region vessel union 3 bowl cone neck\n"
      "region off_hub cylinder z 0 0 {hub} -1 {top} side out units box\n"
      "region off_chopper cylinder x {cy} {cz} {shaft} {from} 1 side out units box\n"
      "region space intersect 3 vessel off_hub off_chopper",
      fmt::arg("low", low), fmt::arg("high", high), fmt::arg("h1", b.cylinder_height), fmt::arg("h2", b.cover_height),
      fmt::arg("h3", b.lid_height), fmt::arg("hub", shafts.hub_radius), fmt::arg("top", shafts.hub_top),
      fmt::arg("cy", shafts.chopper.y), fmt::arg("cz", shafts.chopper.z), fmt::arg("shaft", shafts.chopper_radius),
      fmt::arg("from", shafts.chopper_from));
}

// LIGGGHTS wants primes above 10 000 as seeds.
long prime_seed(long seed, int number) {
  long candidate = 10007L + seed / 16 + 1000L * number;  // different ones for each number
  const auto is_prime = [](long n) {
    for (long d = 2; d * d <= n; ++d)
      if (n % d == 0) return false;
    return true;
  };
  while (!is_prime(candidate)) ++candidate;
  return candidate;
}

}  // namespace

std::string space_commands(const Machine& machine) {
  return machine.type == Machine::Type::cm5 ? mixer_space(machine.mixer) : bowl_space(machine.bowl);
}

Result<std::string> outlet_commands(const HorizontalMixer& m) {
  const MixerPorts ports = mixer_ports(m);
  const double reach = 0.5 * (m.length - m.shaft_length);  // they fly on while they fall
  const double from = ports.outlet_from - reach, to = m.length + 0.1 * m.length;
  const auto outside = [&](double x) { return casing_corner_radius(m, x) + kPastTheWall; };
  return render(templates::outlet, "outlet.tmpl",
                {{"from", digits(from)},
                 {"to", "EDGE"},
                 {"top", digits(-0.2 * m.outlet_diameter)},
                 {"radius_from", digits(outside(from))},
                 {"radius_to", digits(outside(to))},
                 {"cone_from", digits(from)},
                 {"cone_to", digits(to)}});
}

Result<std::string> feed_commands(const DemCase& c) {
  const HorizontalMixer& m = c.machine.mixer;
  const MixerPorts ports = mixer_ports(m);
  const double d = feed_diameter(c), half = ports.chute_half_width - 0.1 * d;
  // Above the blades and below the chute's lid, off its walls.
  return render(templates::feed, "feed.tmpl",
                {{"xlo", digits(ports.chute_from + 0.1 * d)},
                 {"xhi", digits(ports.chute_to - 0.1 * d)},
                 {"ylo", digits(0.5 * (casing_radius(m, ports.chute_to) + ports.chute_top))},
                 {"yhi", digits(ports.chute_top - 0.1 * d)},
                 {"zlo", digits(-half)},
                 {"zhi", digits(half)},
                 {"density", digits(c.density)},
                 {"radius", digits(0.5 * d)},
                 {"rate", digits(c.feed_rate)},
                 {"every", digits(static_cast<double>(feed_every(c)))},
                 {"vx", "0"},
                 {"vy", "-1"},
                 {"vz", "0"},
                 {"seed_1", fmt::format("{}", prime_seed(c.seed, 1))},
                 {"seed_2", fmt::format("{}", prime_seed(c.seed, 2))},
                 {"seed_3", fmt::format("{}", prime_seed(c.seed, 3))}});
}

}  // namespace granary::dem
