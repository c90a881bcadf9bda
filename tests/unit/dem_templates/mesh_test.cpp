#include "dem_templates/geometry/mesh.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/units.hpp"
#include "dem_templates/geometry/solids.hpp"

namespace granary::dem {
namespace {

using testing::HasSubstr;

Mesh a_box() {
  Blade form;
  form.root_radius = 0.1;
  form.tip_radius = 0.5;
  form.width = 0.2;
  form.thickness = 0.05;
  form.angle = 0.3;
  form.pitch = 0.4;
  return blade(form);
}

double furthest_from_axis(const Mesh& mesh) {
  double r = 0.0;
  for (Vec3 p : mesh.vertex) r = std::max(r, std::hypot(p.y, p.z));
  return r;
}

TEST(Mesh, RefiningKeepsVolumeAndClosedness) {
  const Mesh box = a_box();

  for (int n : {2, 3, 7}) {
    const Mesh fine = refine(box, n);
    EXPECT_EQ(fine.triangle.size(), 12u * n * n);
    EXPECT_EQ(defect(fine), std::nullopt);
    EXPECT_NEAR(volume(fine), volume(box), 1e-12 * volume(box));
    // Euler: vertices - edges + triangles = 2 for one closed body, with 3/2 edges a triangle.
    EXPECT_EQ(fine.vertex.size() - fine.triangle.size() / 2, 2u);
  }
}

TEST(Mesh, AMissingTriangleIsAHole) {
  Mesh box = a_box();
  box.triangle.pop_back();
  ASSERT_TRUE(defect(box));
  EXPECT_THAT(*defect(box), HasSubstr("there is a hole"));
}

TEST(Mesh, AFlippedTriangleIsADefect) {
  Mesh box = a_box();
  std::swap(box.triangle[3][0], box.triangle[3][1]);
  ASSERT_TRUE(defect(box));
  EXPECT_THAT(*defect(box), HasSubstr("opposite sides"));
}

TEST(Mesh, ATriangleWithoutAreaIsADefect) {
  Mesh box = a_box();
  box.vertex[box.triangle[0][1]] = box.vertex[box.triangle[0][0]];
  ASSERT_TRUE(defect(box));
  EXPECT_THAT(*defect(box), HasSubstr("has no area"));
}

TEST(Mesh, WeldingJoinsTheCornersOfLooseTriangles) {
  const Mesh box = a_box();
  Mesh loose;
  for (const Corners& t : box.triangle) {
    const int first = static_cast<int>(loose.vertex.size());
    for (int k = 0; k < 3; ++k) loose.vertex.push_back(box.vertex[t[k]] + Vec3{1e-12 * first, 0, 0});
    loose.triangle.push_back({first, first + 1, first + 2});
  }
  ASSERT_TRUE(defect(loose));

  const Mesh joined = weld(loose, 1e-9);

  EXPECT_EQ(joined.vertex.size(), 8u);
  EXPECT_EQ(defect(joined), std::nullopt);
}

TEST(Solids, ABladesTipCornersLieOnTheTipCircle) { EXPECT_NEAR(furthest_from_axis(a_box()), 0.5, 1e-12); }

TEST(Solids, ABladeIsABoxOfItsWidthAndThickness) {
  Blade form;
  form.root_radius = 0.1;
  form.tip_radius = 0.5;
  form.width = 0.2;
  form.thickness = 0.05;  // pitch 0: the corners are half a thickness aside of the radius
  const double span = std::sqrt(0.25 - 0.025 * 0.025) - 0.1;
  EXPECT_NEAR(volume(blade(form)), span * 0.2 * 0.05, 1e-15);
  EXPECT_NEAR(blade_volume(form, 0.0), span * 0.2 * 0.05, 1e-15);
}

TEST(Solids, ABodyOfRevolutionHasThePrismsVolume) {
  for (Axis axis : {Axis::x, Axis::y, Axis::z}) {
    const Mesh prism = body_of_revolution(axis, {{1.0, 0.0}, {1.0, 0.3}, {1.5, 0.3}, {1.5, 0.0}}, 12);
    EXPECT_EQ(defect(prism), std::nullopt);
    EXPECT_NEAR(volume(prism), 0.5 * 6 * std::sin(2 * kPi / 12) * 0.09, 1e-14);
  }
}

TEST(Solids, AVesselIsClosedWithAndWithoutAHoleAndADome) {
  Vessel form;
  form.n_around = 12;
  form.inner = {{0, 0}, {0, 1}, {1, 1}, {2, 1}, {3, 1}, {3, 0}};
  form.outer = {{-0.1, 0}, {-0.1, 1.1}, {0.9, 1.1}, {2.1, 1.1}, {3.1, 1.1}, {3.1, 0}};
  EXPECT_EQ(defect(vessel(form)), std::nullopt);
  const double whole = volume(vessel(form));
  const double prism = 6 * std::sin(2 * kPi / 12);
  EXPECT_NEAR(whole, prism * (1.21 * 3.2 - 3.0), 1e-12);

  form.open = [](int along, int around) { return along == 3 && around >= 5 && around < 7; };
  EXPECT_EQ(defect(vessel(form)), std::nullopt);
  EXPECT_LT(volume(vessel(form)), whole);

  form.raised = [](int along, int around) { return along == 2 && (around < 1 || around >= 11); };
  form.lift_inner = [](Vec3 p) { return Vec3{p.x, 1.5, p.z}; };
  form.lift_outer = [](Vec3 p) { return Vec3{p.x, 1.6, p.z}; };
  EXPECT_EQ(defect(vessel(form)), std::nullopt);
  EXPECT_NEAR(bounding_box(vessel(form)).high.y, 1.6, 1e-12);
}

}  // namespace
}  // namespace granary::dem
