// The vertical batch bowl: cylinder, frustum and neck, a bladed impeller above the bottom and a chopper on a horizontal
// shaft through the side wall. What the source paper leaves open is chosen here and said in docs/dem.md.
#include <algorithm>

#include "common/units.hpp"
#include "dem_templates/geometry/machine.hpp"
#include "dem_templates/geometry/solids.hpp"

namespace granary::dem {
namespace {

constexpr int kBowlSides = 32;  // sides of the bowl at refinement 1; flats touch the nominal circles
constexpr int kBowlShaftSides = 12;
constexpr double kIntoWall = 0.001;          // how far shafts reach into the wall they come through [m]
constexpr double kChopperThickness = 0.002;  // [m]

double gap(const BatchBowl& b) { return 0.5 * (b.bottom_diameter - b.impeller_diameter); }

double chopper_width(const BatchBowl& b) { return 0.25 * b.chopper_diameter; }

double blade_top(const BatchBowl& b) {
  const Blade blade = bowl_blades(b).front();
  return 2.0 * blade.centre.z - gap(b);
}

}  // namespace

std::vector<Blade> bowl_blades(const BatchBowl& b) {
  std::vector<Blade> blades;
  for (int i = 0; i < b.impeller_blades; ++i) {
    Blade form;
    form.axis = Axis::z;
    form.angle = 2.0 * kPi * i / b.impeller_blades;
    form.width = b.impeller_blade_width;
    form.thickness = kBladeThickness;
    form.pitch = b.impeller_pitch;
    form.centre = {0.0, 0.0, gap(b) + half_extent(form)};
    form.root_radius = 0.06 * b.impeller_diameter;
    form.tip_radius = 0.5 * b.impeller_diameter;
    blades.push_back(form);
  }
  return blades;
}

BowlShafts bowl_shafts(const BatchBowl& b) {
  const double radius = 0.5 * b.chopper_diameter;
  const double height =
      std::min(blade_top(b) + radius + b.chopper_clearance, b.lid_height - radius - b.chopper_clearance);
  return {0.1 * b.impeller_diameter,
          blade_top(b) + 0.002,
          {b.chopper_position, 0.0, height},
          0.24 * radius,
          b.chopper_position - 0.5 * chopper_width(b) - 0.001};
}

Mesh bowl_impeller(const BatchBowl& b, int refinement) {
  const auto [hub, top, chopper, r, from] = bowl_shafts(b);
  Mesh mesh = body_of_revolution(Axis::z, {{-kIntoWall, 0.0}, {-kIntoWall, hub}, {top, hub}, {top, 0.0}},
                                 kBowlShaftSides * refinement);
  for (const Blade& form : bowl_blades(b)) append(mesh, refine(blade(form), refinement));
  return mesh;
}

Axle bowl_chopper_rotation(const BatchBowl& b, double speed) { return {bowl_shafts(b).chopper, Axis::x, speed}; }

Mesh bowl_chopper(const BatchBowl& b, int refinement) {
  const BowlShafts shafts = bowl_shafts(b);
  Blade form;
  form.axis = Axis::x;
  form.centre = shafts.chopper;
  form.width = chopper_width(b);
  form.thickness = kChopperThickness;
  form.root_radius = 0.6 * shafts.chopper_radius;
  form.tip_radius = 0.5 * b.chopper_diameter;
  const double from = shafts.chopper_from, r = shafts.chopper_radius, to = 0.5 * b.bottom_diameter + kIntoWall;
  Mesh mesh = body_of_revolution(Axis::x, {{from, 0.0}, {from, r}, {to, r}, {to, 0.0}}, kBowlShaftSides * refinement);
  for (Vec3& p : mesh.vertex) p = p + Vec3{0.0, shafts.chopper.y, shafts.chopper.z};
  for (int i = 0; i < b.chopper_blades; ++i) {
    form.angle = 2.0 * kPi * i / b.chopper_blades;
    append(mesh, refine(blade(form), refinement));
  }
  return mesh;
}

Mesh bowl_shell(const BatchBowl& b, int refinement) {
  const int sides = kBowlSides * refinement;
  const double low = touching_radius(0.5 * b.bottom_diameter, sides);
  const double high = touching_radius(0.5 * b.cover_diameter, sides);
  Vessel form;
  form.axis = Axis::z;
  form.n_around = sides;
  form.inner = {{0.0, 0.0},           {0.0, low},         {b.cylinder_height, low}, {b.cover_height, high},
                {b.lid_height, high}, {b.lid_height, 0.0}};
  form.outer = {{-kWallThickness, 0.0},
                {-kWallThickness, low + kWallThickness},
                {b.cylinder_height, low + kWallThickness},
                {b.cover_height, high + kWallThickness},
                {b.lid_height + kWallThickness, high + kWallThickness},
                {b.lid_height + kWallThickness, 0.0}};
  return vessel(form);
}

}  // namespace granary::dem
