// Neighbour lists made anew when granary/lists says so, in real LIGGGHTS.
#include <cmath>
#include <random>

#include "tests/liggghts/plugin_deck.hpp"
#include "tests/liggghts/wall_deck.hpp"

namespace granary::dem::test {
namespace {

constexpr double kRate = 400.0;  // [rad/s]

/// A ring of particles that turn about x, some faster than others, in an endless cylinder that keeps them.
std::string ring(const std::string& lists) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0), way(-0.5, 0.5);
  std::vector<TestParticle> list;
  for (int k = 0; k < 60; ++k) {
    const double r = k % 2 == 0 ? 0.03 : 0.036, at = 2.0 * M_PI * k / 60.0;
    const double speed = kRate * r * (0.6 + 0.8 * unit(random)), y = r * std::cos(at), z = r * std::sin(at);
    list.push_back({0.01 * unit(random), y, z, way(random), -speed * std::sin(at) + way(random),
                    speed * std::cos(at) + way(random), 0.003});
  }
  return head("-0.02 0.03 -0.05 0.05 -0.05 0.05") + physics(0.9, 0.2, 2e-6, 0.003) + particles(list) +
         "fix walls all granary/wall type 1 cylinder drum 0 0 0 1 0 0 0.04 plane left -0.01 0 0 1 0 0 &\n"
         "          plane right 0.02 0 0 1 0 0\n" +
         lists + tally(kOneBin + "body drum of walls", 1, 500) + "run 3000\n";
}

const std::string kLists = "fix lists all granary/lists axis x\n";

double lists_made(const Folder& folder) {
  const std::string log = folder.read("log.liggghts"), key = "Neighbor list builds = ";
  const auto at = log.rfind(key);
  return at == std::string::npos ? -1.0 : std::stod(log.substr(at + key.size()));
}

double collisions(const Counted& counted, std::size_t window) {
  return counted.windows[window]["collisions"].items()[0].numbers()[0];
}

TEST(Lists, MissNoCollisionAndAreMadeLessOften) {
  const Folder folder;
  ASSERT_EQ(run_deck(folder, ring("")), 0) << folder.read("err");
  const Counted by_liggghts(folder);
  const double often = lists_made(folder);
  ASSERT_EQ(run_deck(folder, ring(kLists)), 0) << folder.read("err");
  const Counted by_us(folder);

  // Rounding grows from collision to collision, so only the first windows are the same to the last one.
  ASSERT_GE(by_us.windows.size(), 4u);
  EXPECT_EQ(collisions(by_us, 0), collisions(by_liggghts, 0));
  EXPECT_GT(by_liggghts.all_collisions(), 20.0);
  EXPECT_NEAR(by_us.all_collisions(), by_liggghts.all_collisions(), 0.1 * by_liggghts.all_collisions());
  EXPECT_GT(often, 10.0);
  EXPECT_LT(lists_made(folder), 0.6 * often);
}

TEST(Lists, AreMadeAtTheSameStepsOnTwoRanks) {
  const Folder folder;
  ASSERT_EQ(run_deck(folder, ring(kLists)), 0) << folder.read("err");
  const Counted one(folder);
  const double made = lists_made(folder);
  ASSERT_EQ(run_deck(folder, "processors 2 1 1\n" + ring(kLists), 2), 0) << folder.read("err");

  EXPECT_EQ(collisions(Counted(folder), 0), collisions(one, 0));
  EXPECT_NEAR(lists_made(folder), made, 0.05 * made + 1.0);
}

/// A dense cloud of sizes 1:5 in a box that goes on at its other side: pairs across it, with spin by friction.
std::string cloud(const std::string& more = "") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0.0, 1.0), way(-1.0, 1.0);
  std::vector<TestParticle> list;
  for (int k = 0; k < 216; ++k) {
    const double diameter = k % 4 == 0 ? 0.0045 : 0.0009 + 0.002 * unit(random);
    list.push_back({0.0025 + 0.005 * (k % 6), 0.0025 + 0.005 * (k / 6 % 6), 0.0025 + 0.005 * (k / 36), way(random),
                    way(random), way(random), diameter});
  }
  return head("0 0.03 0 0.03 0 0.03", "p p p") + physics(0.8, 0.4, 2e-6, 0.001) + particles(list) + more +
         "fix gravity all gravity 9.80665 vector 0 -1 0.3\n" + run(1500, 250);
}

/// Particles that a force acts on.
int touching(const Frame& frame) {
  int n = 0;
  for (const auto& [id, state] : frame) n += state.force[0] != 0.0 ? 1 : 0;
  return n;
}

/// The first two are worked out in rows of pairs, the third by LIGGGHTS.
TEST(Lists, OfOursGiveThePathsThatLiggghtsItselfGives) {
  for (const std::string law : {"", " rolling_friction epsd2", " cohesion sjkr rolling_friction cdt"}) {
    const auto with_law = [&law](std::string deck) {
      const std::string plain = "pair_style gran model hertz tangential history";
      return deck.replace(deck.find(plain), plain.size(),
                          "fix mr all property/global coefficientRollingFriction peratomtypepair 1 0.1\n"
                          "fix mc all property/global cohesionEnergyDensity peratomtypepair 1 2e4\n" +
                              plain + law);
    };
    const Folder folder;
    folder.write("in.stock", with_law(cloud()));
    ASSERT_EQ(shell(folder, "liggghts -in in.stock"), 0) << folder.read("err");
    const auto stock = read_dump(folder);
    ASSERT_EQ(stock.size(), 7u);
    ASSERT_GT(touching(stock.back()), 20);
    ASSERT_EQ(run_deck(folder, with_law(cloud())), 0) << folder.read("err");
    EXPECT_LT(difference(read_dump(folder), stock), 1e-9) << law;
    ASSERT_EQ(run_deck(folder, "processors 2 1 1\n" + with_law(cloud(kLists)), 2), 0) << folder.read("err");
    EXPECT_LT(difference(read_dump(folder), stock), 1e-9) << law;
  }
}

// A pressure asks for virials: LIGGGHTS works those steps out, ours the others, from one memory of the contacts.
TEST(Lists, OfOursGoOnWhereLiggghtsWorksOutAStep) {
  const std::string pressure =
      "compute p all pressure thermo_temp virial\nthermo 7\nthermo_style custom step atoms c_p\n";
  const Folder folder;
  folder.write("in.stock", cloud());
  ASSERT_EQ(shell(folder, "liggghts -in in.stock"), 0) << folder.read("err");
  const auto stock = read_dump(folder);
  ASSERT_EQ(run_deck(folder, cloud(pressure)), 0) << folder.read("err");
  EXPECT_LT(difference(read_dump(folder), stock), 1e-9);
}

TEST(Lists, RefuseMeshesThatLiggghtsMoves) {
  const Folder folder;
  folder.write("plate.stl",
               "solid p\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.01 0 0\nvertex 0 0.01 0\nendloop\n"
               "endfacet\nendsolid p\n");
  const std::string deck = head("-0.02 0.02 -0.02 0.02 -0.02 0.02") + physics() +
                           particles({{0, 0, 0.01, 0, 0, 0, 0.004}}) +
                           "fix plate all mesh/surface file plate.stl type 1\n"
                           "fix w all wall/gran model hertz tangential history mesh n_meshes 1 meshes plate\n" +
                           kLists + "run 1\n";
  EXPECT_EQ(run_deck(folder, deck), 2);
  EXPECT_NE(folder.read("err").find("does not go with fix 'plate'"), std::string::npos) << folder.read("err");
}

}  // namespace
}  // namespace granary::dem::test
