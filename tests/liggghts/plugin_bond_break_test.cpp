// When a bond of granary/bond breaks, and what is told of it, with real LIGGGHTS.
#include "tests/liggghts/bond_deck.hpp"

namespace granary::dem::test {
namespace {

struct Pulled {
  json::Value line;     // of breaks.jsonl
  double force = 0.0;   // largest on the first sphere before [N]
  double torque = 0.0;  // about the middle of the bond [N m]
  std::vector<Frame> frames;
};

/// Two spheres, the second moved (or both turned) by `motion` until the bond breaks.
Pulled pulled(const Bonds& bonds, const std::string& motion, int steps) {
  const Folder folder;
  Bonds with = bonds;
  with.more += " breaks breaks.jsonl";
  Pulled found;
  found.frames = frames_of(folder, bond_head(kSlowBox) + with.fix() + chain(1) + motion + run(steps, 1));
  const auto told = lines(folder, "breaks.jsonl");
  EXPECT_EQ(told.size(), 1u);
  if (!told.empty()) found.line = told[0];
  for (const Frame& frame : found.frames) {
    found.force = std::max(found.force, length(frame.at(1).force));
    Point moment = frame.at(1).torque;  // less that of the shear force, which acts half the distance away
    const Point lever = cross({0.5 * kSpacing, 0, 0}, frame.at(1).force);
    for (std::size_t d = 0; d < 3; ++d) moment[d] -= lever[d];
    found.torque = std::max(found.torque, length(moment));
  }
  return found;
}

const double kStrength = 1e5;
const Bonds kTears{.tensile_strength = kStrength, .shear_strength = kUnbreakable};
const Bonds kSlides{.tensile_strength = kUnbreakable, .shear_strength = kStrength};

TEST(Bond, TearsAtItsTensileStrengthTimesItsArea) {
  const Pulled p = pulled(kTears, "fix pull tip move linear 0.01 0 0\n", 1000);
  EXPECT_NEAR(p.force / (kStrength * kArea), 1.0, 5e-3);
  EXPECT_EQ(p.line["mode"].as_string(), "tension");
  EXPECT_NEAR(p.line["stress_pa"].as_number() / kStrength, 1.0, 5e-3);
  EXPECT_EQ(p.line["fragment_spheres"].as_integer(), 2);
  EXPECT_EQ(p.line["cause"].as_string(), "none");
  EXPECT_NEAR(p.line["position_m"].items()[0].as_number(), 0.5 * (kSpacing + kStrength / kNormal), 1e-6);
  EXPECT_LT(length(p.frames.back().at(1).force), 1e-20);
}

TEST(Bond, SlidesOffAtItsShearStrengthTimesItsArea) {
  const Pulled p = pulled(kSlides, "fix pull tip move linear 0 0.02 0\n", 1000);
  EXPECT_NEAR(p.force / (kStrength * kArea), 1.0, 6e-3);
  EXPECT_EQ(p.line["mode"].as_string(), "shear");
  EXPECT_NEAR(p.line["stress_pa"].as_number() / kStrength, 1.0, 5e-3);
}

TEST(Bond, BreaksByTorsionAtStrengthTimesJOverR) {
  const Pulled p = pulled(kSlides, "set group tip omegax 20\n", 2000);
  EXPECT_NEAR(p.torque / (kStrength * 2.0 * kSecondMoment / kBondRadius), 1.0, 5e-3);
  EXPECT_EQ(p.line["mode"].as_string(), "torsion");
}

TEST(Bond, BreaksByBendingAtStrengthTimesIOverR) {
  const Pulled p = pulled(kTears, "set group tip omegay 5\nset group clamped omegay -5\n", 2000);
  EXPECT_NEAR(p.torque / (kStrength * kSecondMoment / kBondRadius), 1.0, 5e-3);
  EXPECT_EQ(p.line["mode"].as_string(), "bending");
}

TEST(Bond, IsNotBrokenByPressure) {
  const Folder folder;
  Bonds bonds{.tensile_strength = 1.0, .shear_strength = 1.0};
  bonds.more += " breaks breaks.jsonl";
  ASSERT_EQ(run_deck(folder,
                     bond_head(kSlowBox) + bonds.fix() + chain(1) + "fix push tip move linear -0.004 0 0\nrun 1000\n"),
            0)
      << folder.read("err");
  EXPECT_TRUE(lines(folder, "breaks.jsonl").empty());
}

// Pulled and sheared alike: by each test alone it holds at 0.9 of both strengths, by the combined one it does not.
TEST(Bond, BreaksEarlierByTheCombinedCriterion) {
  const double shear_strength = kStrength * kShear / kNormal;
  const std::string motion = "fix pull tip move linear 0.01 0.01 0\n";
  Bonds bonds{.tensile_strength = kStrength, .shear_strength = shear_strength};
  const double by_two = pulled(bonds, motion, 1000).line["stress_pa"].as_number();
  bonds.more += " criterion combined";
  const Pulled combined = pulled(bonds, motion, 1000);
  const double time = combined.line["time_s"].as_number();
  EXPECT_NEAR(by_two / (by_two > 0.7 * kStrength ? kStrength : shear_strength), 1.0, 1e-2);
  // The distance grows by 0.01 t, the slip by nearly as much: both ratios are 0.01 t k_n / sigma.
  EXPECT_NEAR(0.01 * time * kNormal / kStrength, std::sqrt(0.5), 1e-2);
}

TEST(Bond, ScattersItsStrengthByWeibullTheSameOnEveryRunAndMeanOne) {
  // 200 pairs, each torn; the stress told is its strength.
  std::vector<TestParticle> list;
  for (int k = 0; k < 200; ++k) {
    const double y = -0.05 + 0.005 * (k % 20), z = -0.025 + 0.005 * (k / 20);
    list.push_back({0, y, z, 0, 0, 0, 2 * kRadius});
    list.push_back({kSpacing, y, z, 0, 0, 0, 2 * kRadius});
  }
  const auto strengths = [&](const std::string& scatter) {
    const Folder folder;
    Bonds bonds = kTears;
    bonds.more += " breaks breaks.jsonl seed 3 " + scatter;
    EXPECT_EQ(run_deck(folder, bond_head(kSlowBox) + bonds.fix() + particles(list) +
                                   "region far block 0.002 0.06 -0.06 0.06 -0.06 0.06 units box\ngroup far region far\n"
                                   "fix pull far move linear 0.05 0 0\nrun 500\n"),
              0)
        << folder.read("err");
    std::map<std::int64_t, double> found;
    for (const json::Value& line : lines(folder, "breaks.jsonl"))
      found[line["tags"].items()[0].as_integer()] = line["stress_pa"].as_number() / kStrength;
    return found;
  };
  const auto scattered = strengths("weibull 5");
  ASSERT_EQ(scattered.size(), 200u);
  double mean = 0.0, square = 0.0;
  for (const auto& [tag, strength] : scattered) mean += strength / 200, square += strength * strength / 200;
  EXPECT_NEAR(mean, 1.0, 0.06);                               // 0.23 / sqrt(200) = 0.016
  EXPECT_NEAR(std::sqrt(square - mean * mean), 0.229, 0.05);  // of Weibull's distribution with modulus 5
  EXPECT_EQ(scattered, strengths("weibull 5"));
  for (const auto& [tag, strength] : strengths("")) EXPECT_NEAR(strength, 1.0, 2e-2);
}

}  // namespace
}  // namespace granary::dem::test
