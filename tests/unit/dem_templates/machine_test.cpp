#include "dem_templates/geometry/machine.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "common/units.hpp"
#include "dem_templates/geometry/horizontal_mixer.hpp"

namespace granary::dem {
namespace {

Machine bowl_machine() {
  Machine bowl;
  bowl.type = Machine::Type::batch_bowl;
  bowl.impeller_speed = 20.0;
  bowl.chopper_speed = 300.0;
  return bowl;
}

double furthest_from(const Mesh& mesh, const Axle& axle) {
  double r = 0.0;
  for (Vec3 p : mesh.vertex) {
    const Vec3 d = p - axle.point;
    r = std::max(r, length(d - dot(d, unit(axle.axis)) * unit(axle.axis)));
  }
  return r;
}

double sum(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

TEST(Machine, EveryBodyIsClosedAndLooksOutwardsAtEveryRefinement) {
  for (Machine machine : {Machine{}, bowl_machine()})
    for (int n : {1, 2, 3}) {
      machine.refinement = n;
      const auto all = bodies(machine);
      ASSERT_TRUE(all) << all.error().message;
      for (const Body& body : *all) {
        EXPECT_EQ(defect(body.mesh), std::nullopt) << body.name << ", refinement " << n;
        EXPECT_GT(volume(body.mesh), 0.0) << body.name;
      }
    }
}

TEST(Machine, OrdersShellImpellerAndChopper) {
  const auto all = bodies(bowl_machine());
  ASSERT_TRUE(all);
  ASSERT_EQ(all->size(), 3u);
  EXPECT_EQ((*all)[0].name, "shell");
  EXPECT_FALSE((*all)[0].rotation);
  EXPECT_EQ((*all)[1].name, "impeller");
  EXPECT_DOUBLE_EQ((*all)[1].rotation->speed, 20.0);
  EXPECT_EQ((*all)[2].name, "chopper");
  EXPECT_DOUBLE_EQ((*all)[2].rotation->speed, 300.0);
}

TEST(Machine, TipCirclesAreTheStatedDiameters) {
  const HorizontalMixer mixer;
  const BatchBowl bowl;
  EXPECT_NEAR(furthest_from(mixer_impeller(mixer), {}), 0.057, 1e-12);
  EXPECT_NEAR(furthest_from(bowl_impeller(bowl), {{}, Axis::z, 0}), 0.0396, 1e-12);
  EXPECT_NEAR(furthest_from(bowl_chopper(bowl), bowl_chopper_rotation(bowl, 0)), 0.011, 1e-12);
}

TEST(Machine, TheUnrefinedImpellerOfTheMixerHasFewTriangles) {
  EXPECT_LE(mixer_impeller({}).triangle.size(), 400u);
  EXPECT_LE(mixer_shell({}).triangle.size(), 1000u);
}

TEST(Machine, RefiningBringsTheCasingNearerToTheCone) {
  const HorizontalMixer m;
  const auto furthest = [&](int n) {
    double r = 0.0;
    for (Vec3 p : mixer_shell(m, n).vertex)
      if (p.y < 0.0 && std::abs(p.x - m.length) < 1e-9) r = std::max(r, std::hypot(p.y, p.z));
    return r;
  };
  EXPECT_NEAR(furthest(1), 0.065 / std::cos(kPi / 24), 1e-12);
  EXPECT_NEAR(furthest(4), 0.065 / std::cos(kPi / 96), 1e-12);
  EXPECT_NEAR(furthest_from(mixer_impeller(m, 3), {}), 0.057, 1e-12);
}

TEST(Machine, AMixerHasOneBladePerElement) {
  const HorizontalMixer m;
  const auto blades = mixer_blades(m);
  ASSERT_EQ(blades.size(), 28u);
  for (const Blade& b : blades) {
    const Box3 box = bounding_box(blade(b));
    EXPECT_GE(box.low.x, 0.0);
    EXPECT_LE(box.high.x, m.shaft_length + 1e-12);
  }
}

// Volume the shell leaves free = that of the polygonal casing: between the cone and the cone around its corners.
TEST(Machine, TheMixersShellEnclosesTheConeAndItsChute) {
  const HorizontalMixer m;
  const Mesh shell = mixer_shell(m);
  const double r0 = 0.060, r1 = 0.065, cone = kPi / 3 * m.length * (r0 * r0 + r0 * r1 + r1 * r1);
  const MixerPorts ports = mixer_ports(m);
  const double polygon = 24 * std::tan(kPi / 24) / kPi;  // area of the flats' polygon over the circle's
  const double wall = 0.010;
  const auto cone_of = [](double a, double b, double h) { return kPi / 3 * h * (a * a + a * b + b * b); };
  const double outside = polygon * (cone_of(r0 + wall, r1 + wall, m.length) +
                                    kPi * wall * ((r0 + wall) * (r0 + wall) + (r1 + wall) * (r1 + wall)));
  const double metal = outside - polygon * cone;  // without the chute and the hole
  const double hole = (ports.outlet_to - ports.outlet_from) * wall * 2 * ports.outlet_half_width;
  const double chute_wall = 2 * (ports.chute_to - ports.chute_from + 2 * ports.chute_half_width) * wall * 0.04;
  EXPECT_NEAR(volume(shell), metal - hole + chute_wall, 0.1 * metal);
  EXPECT_NEAR(bounding_box(shell).high.y, ports.chute_top + wall, 1e-12);
  EXPECT_NEAR(bounding_box(shell).low.x, -wall, 1e-12);
  EXPECT_NEAR(bounding_box(shell).high.x, m.length + wall, 1e-12);
}

TEST(Machine, TheBowlsShellHasThePolygonalBowlsVolume) {
  const BatchBowl b;
  const double polygon = 32 * std::tan(kPi / 32);
  const double low = 0.040, high = 0.030, wall = 0.010;
  const double corner = 1 / std::cos(kPi / 32);
  const auto frustum = [&](double a, double c, double h) { return h / 3 * (a * a + a * c + c * c); };
  const double inside = frustum(low, low, 0.032) + frustum(low, high, 0.0213) + frustum(high, high, 0.0108);
  const double l = low + wall / corner, h = high + wall / corner;
  const double outside = frustum(l, l, 0.032 + wall) + frustum(l, h, 0.0213) + frustum(h, h, 0.0108 + wall);
  EXPECT_NEAR(volume(bowl_shell(b)), polygon * (outside - inside), 1e-10 * polygon * outside);
}

TEST(Machine, TheImpellersVolumeIsThatOfShaftAndBlades) {
  const HorizontalMixer m;
  double blades = 0.0;
  for (const Blade& b : mixer_blades(m)) blades += blade_volume(b, 0.0);
  const double shaft = 8 * std::sin(2 * kPi / 16) * 0.034 * 0.034 * m.shaft_length;
  EXPECT_NEAR(volume(mixer_impeller(m)), shaft + blades, 1e-9 * shaft);
}

TEST(Machine, NothingOfTheImpellerTouchesTheCasing) {
  const HorizontalMixer m;
  for (Vec3 p : mixer_impeller(m).vertex) EXPECT_LT(std::hypot(p.y, p.z), casing_radius(m, p.x));
  for (Vec3 p : bowl_impeller({}).vertex) EXPECT_LE(std::hypot(p.x, p.y), 0.0396 + 1e-12);
  // The chopper is inside of the bowl but for its shaft, and above the impeller's blades.
  const Axle axle = bowl_chopper_rotation({}, 0);
  for (Vec3 p : bowl_chopper({}).vertex) {
    if (furthest_from(Mesh{{p}, {}}, axle) < 0.004) continue;
    EXPECT_LT(std::hypot(p.x, axle.point.y + 0.011), 0.040);
    EXPECT_GT(p.z, 2 * bowl_blades({}).front().centre.z - 0.0004);
  }
}

TEST(Machine, CompartmentsTakeTheWholeMachineWhateverTheirNumber) {
  for (const Machine& machine : {Machine{}, bowl_machine()}) {
    const double whole = sum(compartment_volume(machine, 1));
    for (int n : {2, 4, 16}) {
      const auto edges = compartment_edges(machine, n);
      ASSERT_EQ(edges.size(), n + 1u);
      EXPECT_EQ(edges.front(), 0.0);
      EXPECT_NEAR(sum(compartment_volume(machine, n)), whole, 1e-12 * whole);
      for (double v : compartment_volume(machine, n)) EXPECT_GT(v, 0.0);
    }
  }
  EXPECT_DOUBLE_EQ(compartment_edges(Machine{}, 4).back(), 0.44);
}

TEST(Machine, TheMixersBedVolumeIsTheAnnulusLessTheBlades) {
  const double annulus = kPi / 3 * 0.44 * (0.06 * 0.06 + 0.06 * 0.065 + 0.065 * 0.065) - kPi * 0.034 * 0.034 * 0.37;
  const double bed = sum(compartment_volume(Machine{}, 4));
  EXPECT_LT(bed, annulus);
  EXPECT_GT(bed, 0.97 * annulus);
  // 110 mm of cone and no shaft from 370 mm on: the last compartment is the largest.
  const auto volumes = compartment_volume(Machine{}, 4);
  EXPECT_GT(volumes[3], volumes[2]);
}

TEST(Machine, TipSpeedAt2000RpmIsTwelveMetresPerSecond) {
  EXPECT_NEAR(tip_speed(Machine{}), 2000.0 / 60 * kPi * 0.114, 1e-3);
  EXPECT_NEAR(tip_speed(bowl_machine()), 300.0 * 0.011, 1e-12);  // the chopper's is the faster one
}

TEST(Machine, AUsersMeshThatIsMissingIsAnErrorThatNamesIt) {
  Machine machine;
  machine.impeller_stl = "/nowhere/paddles.stl";
  const auto all = bodies(machine);
  ASSERT_FALSE(all);
  EXPECT_NE(all.error().message.find("/nowhere/paddles.stl"), std::string::npos);
}

}  // namespace
}  // namespace granary::dem
