// The continuous horizontal mixer: a conical casing with a feed chute on top and an outlet in its floor, and paddles in
// a spiral on a shaft. What the source papers leave open is chosen here and said in docs/dem.md.
#include <algorithm>

#include "common/units.hpp"
#include "dem_templates/geometry/horizontal_mixer.hpp"
#include "dem_templates/geometry/machine.hpp"
#include "dem_templates/geometry/solids.hpp"

namespace granary::dem {
namespace {

constexpr int kCasingSides = 24;  // sides of the casing at refinement 1; flats touch the nominal cone
constexpr int kMixerShaftSides = 16;
constexpr double kEndGap = 0.010;  // from the end plate to the first blade, so that it crushes nothing against it [m]
constexpr double kQuarterTurn = 0.5 * kPi;

// Profile points along the casing: ends, chute, two between, outlet. Cells between points 2-3 and m-3..m-2 open.
std::vector<double> stations(const HorizontalMixer& m) {
  const MixerPorts ports = mixer_ports(m);
  const double from = ports.chute_to, span = ports.outlet_from - ports.chute_to;
  return {0.0,
          ports.chute_from,
          ports.chute_to,
          from + span / 3,
          from + 2 * span / 3,
          ports.outlet_from,
          ports.outlet_to,
          m.length};
}
constexpr int kChuteCell = 2, kOutletCell = 6;  // counted along the profile; cell 0 is the end plate

// The sides about the top (side 0 begins at +y), 60 degrees, or about the bottom, 30 degrees.
bool is_top(int around, int sides) { return around < sides / 12 || around >= sides - sides / 12; }
bool is_bottom(int around, int sides) { return std::abs(2 * around + 1 - sides) < sides / 12; }

}  // namespace

double casing_radius(const HorizontalMixer& m, double x) {
  return 0.5 * (m.inlet_diameter + (m.outlet_diameter - m.inlet_diameter) * x / m.length);
}

double casing_corner_radius(const HorizontalMixer& m, double x) {
  return touching_radius(casing_radius(m, x), kCasingSides);
}

MixerPorts mixer_ports(const HorizontalMixer& m) {
  const double spacing = m.shaft_length / (m.feed_elements + m.shear_elements + m.exit_elements);
  MixerPorts ports;
  ports.chute_from = 0.02 * m.length;
  ports.chute_to = std::clamp(m.feed_elements * spacing, 0.08 * m.length, 0.25 * m.length);
  ports.outlet_from = std::max(m.shaft_length + 0.4 * (m.length - m.shaft_length), 0.8 * m.length);
  ports.outlet_to = m.length - 0.01 * m.length;
  ports.chute_top = casing_corner_radius(m, ports.chute_to) + 0.25 * m.inlet_diameter;
  ports.chute_half_width = casing_radius(m, 0.0) * std::sin(2 * 2 * kPi / kCasingSides);
  ports.outlet_half_width = casing_radius(m, m.length) * std::sin(2 * kPi / kCasingSides);
  return ports;
}

std::vector<Blade> mixer_blades(const HorizontalMixer& m) {
  const int n = m.feed_elements + m.shear_elements + m.exit_elements;
  const double end_gap = std::min(kEndGap, 0.1 * m.shaft_length);
  const double spacing = (m.shaft_length - end_gap) / std::max(n, 1);
  std::vector<Blade> blades;
  for (int i = 0; i < n; ++i) {
    const bool conveys = i < m.feed_elements || i >= n - m.exit_elements;
    Blade b;
    b.axis = Axis::x;
    b.angle = i * kQuarterTurn;
    b.width = 1.2 * spacing;
    b.thickness = kBladeThickness;
    b.pitch = conveys ? kPi / 4 : kPi / 9;
    const double half = half_extent(b);
    b.centre = {std::clamp(end_gap + (i + 0.5) * spacing, end_gap + half, m.shaft_length - half), 0.0, 0.0};
    b.root_radius = 0.4 * m.shaft_diameter;
    b.tip_radius = 0.5 * m.impeller_diameter;
    blades.push_back(b);
  }
  return blades;
}

Mesh mixer_impeller(const HorizontalMixer& m, int refinement) {
  const double r = 0.5 * m.shaft_diameter;
  Mesh mesh = body_of_revolution(Axis::x, {{0.0, 0.0}, {0.0, r}, {m.shaft_length, r}, {m.shaft_length, 0.0}},
                                 kMixerShaftSides * refinement);
  for (const Blade& b : mixer_blades(m)) append(mesh, refine(blade(b), refinement));
  return mesh;
}

Mesh mixer_shell(const HorizontalMixer& m, int refinement) {
  const int sides = kCasingSides * refinement;
  const MixerPorts ports = mixer_ports(m);
  Vessel form;
  form.axis = Axis::x;
  form.n_around = sides;
  const std::vector<double> x = stations(m);
  form.inner.push_back({0.0, 0.0});
  form.outer.push_back({-kWallThickness, 0.0});
  for (std::size_t i = 0; i < x.size(); ++i) {
    form.inner.push_back({x[i], touching_radius(casing_radius(m, x[i]), sides)});
    double outside = x[i];  // the wall's outside reaches past the ends and around the chute
    if (i == 0 || i == 1) outside -= kWallThickness;
    if (i == 2 || i + 1 == x.size()) outside += kWallThickness;
    form.outer.push_back({outside, touching_radius(casing_radius(m, x[i]) + kWallThickness, sides)});
  }
  form.inner.push_back({m.length, 0.0});
  form.outer.push_back({m.length + kWallThickness, 0.0});
  form.open = [sides, open = m.outlet_open](int along, int around) {
    return open && along == kOutletCell && is_bottom(around, sides);
  };
  form.raised = [sides](int along, int around) { return along == kChuteCell && is_top(around, sides); };
  form.lift_inner = [top = ports.chute_top](Vec3 p) { return Vec3{p.x, top, p.z}; };
  form.lift_outer = [top = ports.chute_top + kWallThickness](Vec3 p) { return Vec3{p.x, top, p.z}; };
  return vessel(form);
}

}  // namespace granary::dem
