// A state is made to hold a population: sizes by rank, places without overlap, the same on every rank.
#include "dem_templates/plugin/resize/plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <set>

#include "dem_templates/plugin/resize/packing.hpp"
#include "dem_templates/plugin/resize/triangles.hpp"

namespace granary::dem {
namespace {

// A closed box.
class BoxSpace : public FreeSpace {
 public:
  explicit BoxSpace(Vector3 high) : high_(high) {}
  bool inside(const Vector3& p) const override {
    for (std::size_t d = 0; d < 3; ++d)
      if (p[d] < 0.0 || p[d] > high_[d]) return false;
    return true;
  }
  void walls_near(const Vector3& p, double reach, std::vector<NearWall>& found) const override {
    for (std::size_t d = 0; d < 3; ++d) {
      Vector3 normal{};
      normal[d] = 1.0;
      if (p[d] < reach) found.push_back({p[d], normal});
      if (high_[d] - p[d] < reach) found.push_back({high_[d] - p[d], -1.0 * normal});
    }
  }
  Vector3 low() const override { return {0.0, 0.0, 0.0}; }
  Vector3 high() const override { return high_; }

 private:
  Vector3 high_;
};

const BoxSpace kBox({0.1, 0.04, 0.04});

ResizePopulation two_compartments(std::vector<double> left, std::vector<double> right) {
  std::sort(left.begin(), left.end());
  std::sort(right.begin(), right.end());
  return {1000.0, {{0.0, 0.05, std::move(left)}, {0.05, 0.1, std::move(right)}}};
}

std::vector<Particle> all_of(const ResizePlan& plan) {
  std::vector<Particle> all = plan.kept;
  all.insert(all.end(), plan.inserted.begin(), plan.inserted.end());
  return all;
}

double overlap_of(const std::vector<Particle>& particles, const FreeSpace& space) {
  double worst = 0.0;
  std::vector<NearWall> walls;
  for (std::size_t a = 0; a < particles.size(); ++a) {
    const double ra = 0.5 * particles[a].diameter;
    for (std::size_t b = 0; b < a; ++b) {
      const double rb = 0.5 * particles[b].diameter;
      worst = std::max(worst, (ra + rb - norm(particles[a].centre - particles[b].centre)) / std::min(ra, rb));
    }
    walls.clear();
    space.walls_near(particles[a].centre, ra, walls);
    for (const NearWall& wall : walls) worst = std::max(worst, 1.0 - wall.distance / ra);
  }
  return worst;
}

std::vector<double> diameters_in(const std::vector<Particle>& particles, double from, double to) {
  std::vector<double> found;
  for (const Particle& p : particles)
    if (p.centre[0] >= from && p.centre[0] <= to) found.push_back(p.diameter);
  std::sort(found.begin(), found.end());
  return found;
}

TEST(ResizePlan, FillsAnEmptyBoxWithExactlyWhatIsAsked) {
  const ResizePopulation population =
      two_compartments(std::vector<double>(150, 0.004), std::vector<double>(400, 0.003));

  const auto plan = plan_resize({}, population, kBox, {});

  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_EQ(plan->kept.size(), 0u);
  EXPECT_EQ(diameters_in(plan->inserted, 0.0, 0.05), std::vector<double>(150, 0.004));
  EXPECT_EQ(diameters_in(plan->inserted, 0.05, 0.1), std::vector<double>(400, 0.003));
  EXPECT_LE(overlap_of(plan->inserted, kBox), 0.02);
}

TEST(ResizePlan, IsTheSameWhateverTheOrderParticlesComeIn) {
  const ResizePopulation before = two_compartments(std::vector<double>(100, 0.004), std::vector<double>(100, 0.004));
  auto state = plan_resize({}, before, kBox, {})->inserted;
  const ResizePopulation after = two_compartments(std::vector<double>(130, 0.0045), std::vector<double>(80, 0.005));
  const auto one = plan_resize(state, after, kBox, {.seed = 5});
  std::shuffle(state.begin(), state.end(), std::mt19937(3));
  const auto other = plan_resize(state, after, kBox, {.seed = 5});

  const auto a = all_of(*one), b = all_of(*other);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].tag, b[i].tag);
    EXPECT_EQ(a[i].centre, b[i].centre);
    EXPECT_EQ(a[i].diameter, b[i].diameter);
  }
}

TEST(ResizePlan, GivesTheLargestParticleTheLargestSize) {
  std::vector<Particle> state;
  for (int i = 0; i < 5; ++i) state.push_back({i + 1, {0.005 + 0.01 * i, 0.02, 0.02}, 0.005 - 0.0005 * i});
  const ResizePopulation population = two_compartments({0.001, 0.002, 0.003, 0.004, 0.006}, {});

  const auto plan = plan_resize(state, population, kBox, {});

  ASSERT_TRUE(plan);
  ASSERT_EQ(plan->kept.size(), 5u);
  EXPECT_EQ(plan->kept[0].diameter, 0.006);  // tag 1 was the largest
  EXPECT_EQ(plan->kept[4].diameter, 0.001);
}

TEST(ResizePlan, TakesSurplusEvenlyOverTheSizes) {
  std::vector<Particle> state;
  for (int i = 0; i < 100; ++i) state.push_back({i + 1, {0.0005 * i, 0.02, 0.02}, 0.0001 + 1e-6 * i});
  const ResizePopulation population = two_compartments(std::vector<double>(50, 0.0001), {});

  const auto plan = plan_resize(state, population, kBox, {});

  ASSERT_TRUE(plan);
  ASSERT_EQ(plan->removed.size(), 50u);
  const auto small = std::count_if(plan->removed.begin(), plan->removed.end(), [](auto tag) { return tag <= 50; });
  EXPECT_NEAR(static_cast<double>(small), 25.0, 1.0);
}

// The four changes between two bursts: volume is what the file says, overlaps are relaxed.
struct Change {
  std::string name;
  double factor;  // of the diameter
  std::size_t count;
};
class ResizeChanges : public testing::TestWithParam<Change> {};

TEST_P(ResizeChanges, KeepsVolumeAndBoundsOverlaps) {
  const ResizePopulation before = two_compartments(std::vector<double>(200, 0.004), std::vector<double>(200, 0.004));
  const auto state = plan_resize({}, before, kBox, {})->inserted;
  const Change change = GetParam();
  const std::vector<double> sizes(change.count, 0.004 * change.factor);
  const ResizePopulation after = two_compartments(sizes, sizes);

  const auto plan = plan_resize(state, after, kBox, {});

  ASSERT_TRUE(plan) << plan.error().message;
  const auto particles = all_of(*plan);
  EXPECT_EQ(diameters_in(particles, 0.0, 0.05).size(), change.count);
  EXPECT_EQ(diameters_in(particles, 0.05, 0.1).size(), change.count);
  double volume = 0.0;
  std::set<std::int64_t> tags;
  for (const Particle& p : particles) {
    volume += std::numbers::pi / 6.0 * std::pow(p.diameter, 3);
    tags.insert(p.tag);
    EXPECT_TRUE(kBox.inside(p.centre));
  }
  EXPECT_NEAR(volume, 2.0 * after.compartments[0].volume(), 1e-12 * volume);
  EXPECT_EQ(tags.size(), particles.size());
  EXPECT_LE(overlap_of(particles, kBox), 0.02);
  EXPECT_NEAR(plan->overlap, overlap_of(particles, kBox), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(BetweenBursts, ResizeChanges,
                         testing::Values(Change{"grown", 1.5, 59}, Change{"shrunk", 0.8, 200},
                                         Change{"twice", 0.79, 400}, Change{"half", 1.26, 100},
                                         Change{"same", 1.0, 200}, Change{"fuller", 1.25, 200}),
                         [](const auto& test) { return test.param.name; });

// The box with a plate across it, 2 mm above its floor: a slot that a small particle may lie in.
class SlotSpace : public BoxSpace {
 public:
  using BoxSpace::BoxSpace;
  void walls_near(const Vector3& p, double reach, std::vector<NearWall>& found) const override {
    BoxSpace::walls_near(p, reach, found);
    if (p[0] > 0.04) return;
    const double above = p[1] - 0.002;
    if (std::abs(above) < reach) found.push_back({std::abs(above), {0.0, above > 0.0 ? 1.0 : -1.0, 0.0}});
  }
};

TEST(ResizePlan, FreesAParticleThatGrewInANarrowGap) {
  const SlotSpace slot({0.1, 0.04, 0.04});
  const std::vector<Particle> in_slot{{1, {0.01, 0.001, 0.02}, 0.0018}};

  const auto plan = plan_resize(in_slot, two_compartments({0.006}, {}), slot, {});

  ASSERT_TRUE(plan) << plan.error().message;
  ASSERT_EQ(1u, plan->kept.size());
  EXPECT_LE(plan->overlap, ResizeOptions{}.overlap);
  EXPECT_LE(overlap_of(all_of(*plan), slot), ResizeOptions{}.overlap);
}

// How often a relaxation looks at the walls is how much it does.
class CountedBox : public BoxSpace {
 public:
  using BoxSpace::BoxSpace;
  void walls_near(const Vector3& p, double reach, std::vector<NearWall>& found) const override {
    ++looks;
    BoxSpace::walls_near(p, reach, found);
  }
  mutable int looks = 0;
};

TEST(Relaxation, LooksNoMoreAtSpheresThatHaveComeToRest) {
  const CountedBox box({0.1, 0.04, 0.05});
  constexpr int kOthers = 400;
  std::vector<Sphere> spheres{{{0.0005, 0.02, 0.02}, 0.003, 0.0, 0.001}};  // too near to the end, and must stay there
  for (int k = 0; k < kOthers; ++k)
    spheres.push_back({{0.05 + 0.0021 * (k % 20), 0.0009, 0.0012 + 0.0021 * (k / 20)}, 0.001, 0.0, 0.1});

  const Relaxation done = relax(spheres, box, 0, 0.02, 2000);

  EXPECT_GE(done.sweeps, 400);
  EXPECT_GT(done.overlap, 0.5);
  EXPECT_LT(box.looks, 10 * kOthers + 20 * done.sweeps);
  spheres.erase(spheres.begin());
  EXPECT_LE(largest_overlap(spheres, box), 0.02);
}

TEST(ResizePlan, RefusesWhatCannotFit) {
  const ResizePopulation population =
      two_compartments(std::vector<double>(20, 0.004), std::vector<double>(3000, 0.004));
  const auto plan = plan_resize({}, population, kBox, {.sweeps = 200});
  ASSERT_FALSE(plan);
  EXPECT_NE(plan.error().message.find("3000 particles"), std::string::npos) << plan.error().message;
  EXPECT_NE(plan.error().message.find("do not fit between 0.05 m and 0.1 m"), std::string::npos)
      << plan.error().message;
  EXPECT_EQ(plan.error().exit, Exit::bad_input);
}

TEST(Triangles, KnowTheNearestPointOfEveryRegionOfATriangle) {
  const Triangle triangle{Vector3{0, 0, 0}, Vector3{1, 0, 0}, Vector3{0, 1, 0}};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-1.0, 2.0);
  for (int n = 0; n < 2000; ++n) {
    const Vector3 p{coordinate(random), coordinate(random), coordinate(random)};
    const Vector3 found = nearest_point(triangle, p);
    EXPECT_GE(found[0], -1e-12);
    EXPECT_GE(found[1], -1e-12);
    EXPECT_LE(found[0] + found[1], 1.0 + 1e-12);
    double least = 1e9;  // against a fine grid of points of the triangle
    for (int i = 0; i <= 40; ++i)
      for (int j = 0; j <= 40 - i; ++j) least = std::min(least, norm(p - Vector3{i / 40.0, j / 40.0, 0.0}));
    EXPECT_LE(norm(p - found), least + 1e-12);
    EXPECT_GE(norm(p - found), least - 0.05);
  }
}

TEST(Triangles, FindAllThatAreNearAndNoOthers) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> coordinate(0.0, 1.0);
  std::vector<Triangle> list;
  for (int t = 0; t < 60; ++t) {
    Triangle triangle;
    for (Vector3& corner : triangle) corner = {coordinate(random), coordinate(random), coordinate(random)};
    list.push_back(triangle);
  }
  const Triangles triangles(list, 0.05);
  for (int n = 0; n < 500; ++n) {
    const Vector3 p{1.2 * coordinate(random) - 0.1, coordinate(random), coordinate(random)};
    std::vector<NearWall> found;
    triangles.near(p, 0.05, found);
    const auto near = std::count_if(list.begin(), list.end(),
                                    [&](const Triangle& t) { return norm(p - nearest_point(t, p)) < 0.05; });
    EXPECT_EQ(static_cast<long>(found.size()), near);
  }
}

class PopulationFile : public testing::Test {
 protected:
  std::string fault(const std::string& text) {
    const std::string file = testing::TempDir() + "population.json";
    std::ofstream(file) << text;
    const auto population = read_population(file);
    return population ? "" : population.error().message;
  }
};

TEST_F(PopulationFile, IsReadOrRefusedWithEveryProblem) {
  EXPECT_EQ(fault(R"({"format": "granary-population-1", "density_kg_m3": 1000.0, "coarse_graining": 40.0,
    "compartments": [{"from_m": 0.0, "to_m": 0.11, "diameters_m": [0.004, 0.003], "counts": [120, 300]}]})"),
            "");
  EXPECT_NE(
      fault(R"({"format": "granary-population-1", "density_kg_m3": -1, "compartments": []})").find("/density_kg_m3"),
      std::string::npos);
  EXPECT_NE(fault(R"({"format": "granary-population-1", "density_kg_m3": 1,
    "compartments": [{"from_m": 0.0, "to_m": 0.11, "diameters_m": [0.003], "counts": [1, 2]}]})")
                .find("as many"),
            std::string::npos);
  EXPECT_NE(fault(R"({"format": "granary-population-1", "density_kg_m3": 1,
    "compartments": [{"from_m": 0.0, "to_m": 0.11, "diameters_m": [0.003], "counts": [0]}]})")
                .find("no particles"),
            std::string::npos);
}

}  // namespace
}  // namespace granary::dem
