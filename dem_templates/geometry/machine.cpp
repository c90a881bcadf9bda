#include "dem_templates/geometry/machine.hpp"

#include <algorithm>

#include "common/assert.hpp"
#include "common/units.hpp"
#include "dem_templates/geometry/horizontal_mixer.hpp"
#include "dem_templates/geometry/stl.hpp"

namespace granary::dem {
namespace {

constexpr double kRoomAround = 0.015;  // of the simulation box around the bodies [m]

// Our mesh, or the user's own in its place.
Result<Mesh> own_or(const std::optional<std::filesystem::path>& file, Mesh ours) {
  if (file) return read_stl(*file);
  return ours;
}

double bowl_radius(const BatchBowl& b, double z) {
  const double low = 0.5 * b.bottom_diameter, high = 0.5 * b.cover_diameter;
  if (z <= b.cylinder_height) return low;
  if (z >= b.cover_height) return high;
  return low + (high - low) * (z - b.cylinder_height) / (b.cover_height - b.cylinder_height);
}

// Volume of revolution of a profile that is linear between the given breaks [m^3].
template <class Radius>
double revolved(double from, double to, std::vector<double> breaks, const Radius& radius) {
  breaks.push_back(to);
  std::sort(breaks.begin(), breaks.end());
  double sum = 0.0;
  for (double end : breaks) {
    end = std::clamp(end, from, to);
    const double a = radius(from), b = radius(end);
    sum += kPi / 3.0 * (end - from) * (a * a + a * b + b * b);
    from = end;
  }
  return sum;
}

double share_inside(double low, double high, double from, double to) {
  return std::max(0.0, std::min(high, to) - std::max(low, from)) / (high - low);
}

// Blades are shared between slices by their extent along the axis.
double blades_inside(const std::vector<Blade>& blades, double shaft_radius, Axis axis, double from, double to) {
  double sum = 0.0;
  for (const Blade& b : blades) {
    const double half = half_extent(b);
    const double at = dot(b.centre, unit(axis));
    sum += blade_volume(b, shaft_radius) * share_inside(at - half, at + half, from, to);
  }
  return sum;
}

double mixer_space(const HorizontalMixer& m, double from, double to) {
  const double shaft = 0.5 * m.shaft_diameter;
  const double casing = revolved(from, to, {}, [&](double x) { return casing_radius(m, x); });
  const double shaft_inside = m.shaft_length * share_inside(0.0, m.shaft_length, from, to) * kPi * shaft * shaft;
  return casing - shaft_inside - blades_inside(mixer_blades(m), shaft, Axis::x, from, to);
}

// The hub and the chopper are left out: together below 3 % of the bowl.
double bowl_space(const BatchBowl& b, double from, double to) {
  const double bowl =
      revolved(from, to, {b.cylinder_height, b.cover_height}, [&](double z) { return bowl_radius(b, z); });
  return bowl - blades_inside(bowl_blades(b), 0.1 * b.impeller_diameter, Axis::z, from, to);
}

}  // namespace

Result<std::vector<Body>> bodies(const Machine& machine) {
  const bool mixer = machine.type == Machine::Type::cm5;
  const int n = machine.refinement;
  GRANARY_TRY(Mesh shell,
              own_or(machine.shell_stl, mixer ? mixer_shell(machine.mixer, n) : bowl_shell(machine.bowl, n)));
  GRANARY_TRY(Mesh impeller,
              own_or(machine.impeller_stl, mixer ? mixer_impeller(machine.mixer, n) : bowl_impeller(machine.bowl, n)));
  std::vector<Body> all;
  all.push_back({"shell", std::move(shell), std::nullopt});
  all.push_back({"impeller", std::move(impeller), Axle{{}, axis_of(machine), machine.impeller_speed}});
  if (!mixer)
    all.push_back(
        {"chopper", bowl_chopper(machine.bowl, n), bowl_chopper_rotation(machine.bowl, machine.chopper_speed)});
  return all;
}

std::vector<double> compartment_edges(const Machine& machine, int n) {
  GRANARY_ASSERT(n >= 1, n);
  const double end = machine.type == Machine::Type::cm5 ? machine.mixer.length : machine.bowl.lid_height;
  std::vector<double> edges;
  for (int i = 0; i <= n; ++i) edges.push_back(i == n ? end : end * i / n);
  return edges;
}

std::vector<double> compartment_volume(const Machine& machine, int n) {
  const std::vector<double> edges = compartment_edges(machine, n);
  std::vector<double> volumes;
  for (int i = 0; i < n; ++i)
    volumes.push_back(machine.type == Machine::Type::cm5 ? mixer_space(machine.mixer, edges[i], edges[i + 1])
                                                         : bowl_space(machine.bowl, edges[i], edges[i + 1]));
  return volumes;
}

double tip_speed(const Machine& machine) {
  if (machine.type == Machine::Type::cm5)
    return std::abs(machine.impeller_speed) * 0.5 * machine.mixer.impeller_diameter;
  return std::max(std::abs(machine.impeller_speed) * 0.5 * machine.bowl.impeller_diameter,
                  std::abs(machine.chopper_speed) * 0.5 * machine.bowl.chopper_diameter);
}

double largest_particle(const Machine& machine) {
  constexpr double kShareOfGap = 0.45;  // two abreast, with some air
  if (machine.type == Machine::Type::cm5) {
    const double casing = std::min(machine.mixer.inlet_diameter, machine.mixer.outlet_diameter);
    return kShareOfGap * 0.5 * (casing - machine.mixer.shaft_diameter);
  }
  return kShareOfGap * (0.5 * machine.bowl.cover_diameter - bowl_shafts(machine.bowl).hub_radius);
}

Axis axis_of(const Machine& machine) { return machine.type == Machine::Type::cm5 ? Axis::x : Axis::z; }

Vec3 gravity_direction(const Machine& machine) {
  return machine.type == Machine::Type::cm5 ? Vec3{0, -1, 0} : Vec3{0, 0, -1};
}

Box3 simulation_box(const std::vector<Body>& all) {
  Mesh everything;
  for (const Body& body : all) append(everything, body.mesh);
  Box3 box = bounding_box(everything);
  const Vec3 room{kRoomAround, kRoomAround, kRoomAround};
  return {box.low - room, box.high + room};
}

}  // namespace granary::dem
