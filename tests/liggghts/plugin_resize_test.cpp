// granary/resize on real LIGGGHTS states: filled from nothing, and resized from a restart. The machine: an annulus
// along x, closed at its ends, with a paddle in it.
#include <cmath>
#include <map>
#include <numbers>

#include "tests/liggghts/plugin_deck.hpp"

namespace granary::dem::test {
namespace {

constexpr double kOuter = 0.03, kInner = 0.01, kHalf = 0.03;

struct Sizes {
  std::vector<double> diameters;
  std::vector<long> counts;
};

std::string population(const Sizes& left, const Sizes& right) {
  json::Value compartments = json::Value::array();
  double from = 0.0;
  for (const Sizes* sizes : {&left, &right}) {
    json::Value counts = json::Value::array();
    for (long n : sizes->counts) counts.push(static_cast<std::int64_t>(n));
    compartments.push(json::Value::object(
        {{"from_m", from}, {"to_m", from + kHalf}, {"diameters_m", sizes->diameters}, {"counts", counts}}));
    from += kHalf;
  }
  return json::dump(json::Value::object({{"format", "granary-population-1"},
                                         {"density_kg_m3", 1000.0},
                                         {"coarse_graining", 1.0},
                                         {"compartments", compartments}}));
}

double volume(const Sizes& sizes) {
  double sum = 0.0;
  for (std::size_t k = 0; k < sizes.counts.size(); ++k)
    sum += static_cast<double>(sizes.counts[k]) * std::numbers::pi / 6.0 * std::pow(sizes.diameters[k], 3);
  return sum;
}

void write_paddle(const Folder& folder) {
  const auto corner = [](double x, double y) {
    return "vertex " + std::to_string(x) + " " + std::to_string(y) + " 0.0\n";
  };
  const std::string a = corner(0.02, 0.011), b = corner(0.04, 0.011), c = corner(0.04, 0.028), d = corner(0.02, 0.028);
  std::string stl = "solid paddle\n";
  for (const std::string& facet : {a + b + c, a + c + d})
    stl += "facet normal 0 0 1\nouter loop\n" + facet + "endloop\nendfacet\n";
  folder.write("paddle.stl", stl + "endsolid paddle\n");
}

std::string machine(const std::string& start) {
  return head(start) + physics(0.4, 0.5, 2e-5) +
         "region shell cylinder x 0 0 0.03 0 0.06 units box side in\nregion shaft cylinder x 0 0 0.01 -1 1 units box "
         "side out\n"
         "region inside intersect 2 shell shaft\n"
         "fix g all gravity 9.81 vector 0 0 -1\n"
         "fix w1 all wall/gran model hertz tangential history primitive type 1 xplane 0\n"
         "fix w2 all wall/gran model hertz tangential history primitive type 1 xplane 0.06\n"
         "fix w3 all wall/gran model hertz tangential history primitive type 1 xcylinder 0.03 0 0\n"
         "fix w4 all wall/gran model hertz tangential history primitive type 1 xcylinder 0.01 0 0\n"
         "fix paddle all mesh/surface file paddle.stl type 1\n"
         "fix walls all wall/gran model hertz tangential history mesh n_meshes 1 meshes paddle\n"
         "fix guard all granary/guard file tallies.jsonl every 50\n";
}

const std::string kBox = "-0.001 0.061 -0.031 0.031 -0.031 0.031";
const std::string kResize =
    "fix resize all granary/resize population population.json axis x space inside mesh paddle report resize.json seed "
    "7\n";
const std::string kDump =
    "dump d all custom 100000 dump.txt id x y z radius vx vy vz density mass\n"
    "dump_modify d first yes sort id format \"%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\"\n";
const std::string kTally = tally(
    "axis x compartments 2 0 0.03 0.06 classes 2 0.001 0.0035 0.006 body paddle mesh paddle body w1 wall w1 "
    "body w2 wall w2 body w3 wall w3 body w4 wall w4",
    5, 500);

struct Row {
  double x[3], r, v[3], density, mass;
};

std::map<int, Row> first_dump(const Folder& folder) {
  std::ifstream in(folder / "dump.txt");
  std::map<int, Row> rows;
  std::string line;
  std::size_t n = 0;
  while (std::getline(in, line) && line.rfind("ITEM: ATOMS", 0) != 0)
    if (line == "ITEM: NUMBER OF ATOMS") in >> n;
  for (std::size_t k = 0; k < n; ++k) {
    int id = 0;
    Row row;
    in >> id >> row.x[0] >> row.x[1] >> row.x[2] >> row.r >> row.v[0] >> row.v[1] >> row.v[2] >> row.density >>
        row.mass;
    rows[id] = row;
  }
  EXPECT_EQ(rows.size(), n);
  return rows;
}

double largest_overlap(const std::map<int, Row>& rows) {
  double worst = 0.0;
  for (auto a = rows.begin(); a != rows.end(); ++a) {
    const Row& p = a->second;
    const double rho = std::hypot(p.x[1], p.x[2]);
    for (double gap : {p.x[0], 2 * kHalf - p.x[0], kOuter - rho, rho - kInner})
      worst = std::max(worst, 1.0 - gap / p.r);
    const double to_paddle = std::hypot(std::max({0.0, 0.02 - p.x[0], p.x[0] - 0.04}),
                                        std::max({0.0, 0.011 - p.x[1], p.x[1] - 0.028}), p.x[2]);
    worst = std::max(worst, 1.0 - to_paddle / p.r);
    for (auto b = rows.begin(); b != a; ++b) {
      const Row& q = b->second;
      const double distance = std::hypot(p.x[0] - q.x[0], p.x[1] - q.x[1], p.x[2] - q.x[2]);
      worst = std::max(worst, (p.r + q.r - distance) / std::min(p.r, q.r));
    }
  }
  return worst;
}

void expect_holds(const std::map<int, Row>& rows, const Sizes& left, const Sizes& right) {
  std::map<std::pair<bool, long>, long> found, asked;  // compartment and diameter [um]
  double total = 0.0;
  for (const auto& [id, row] : rows) {
    ++found[{row.x[0] >= kHalf, std::lround(2e6 * row.r)}];
    total += 4.0 / 3.0 * std::numbers::pi * std::pow(row.r, 3);
    EXPECT_NEAR(row.mass, 1000.0 * 4.0 / 3.0 * std::numbers::pi * std::pow(row.r, 3), 1e-9 * row.mass);
    EXPECT_EQ(row.density, 1000.0);
  }
  for (std::size_t k = 0; k < left.counts.size(); ++k)
    asked[{false, std::lround(1e6 * left.diameters[k])}] = left.counts[k];
  for (std::size_t k = 0; k < right.counts.size(); ++k)
    asked[{true, std::lround(1e6 * right.diameters[k])}] = right.counts[k];
  EXPECT_EQ(found, asked);
  EXPECT_NEAR(total, volume(left) + volume(right), 1e-9 * total);
}

const Sizes kLeft{{0.003, 0.004}, {300, 120}}, kRight{{0.003, 0.004}, {250, 150}};

class Resize : public testing::Test {
 protected:
  void SetUp() override {
    write_paddle(folder);
    folder.write("population.json", population(kLeft, kRight));
  }
  void settle_and_save() {
    ASSERT_EQ(run_deck(folder, machine(kBox) + kResize + "run 8000\nwrite_restart settled\n"), 0) << folder.read("err");
  }
  const Folder folder;
};

TEST_F(Resize, FillsAnEmptyMachineTheSameOnOneAndOnTwoRanks) {
  const std::string deck = machine(kBox) + kResize + kDump + "run 0\n";
  ASSERT_EQ(run_deck(folder, deck), 0) << folder.read("err");
  const auto one = first_dump(folder);
  expect_holds(one, kLeft, kRight);
  EXPECT_LE(largest_overlap(one), 0.02 + 1e-6);

  ASSERT_EQ(run_deck(folder, deck, 2), 0) << folder.read("err");
  const auto two = first_dump(folder);
  ASSERT_EQ(one.size(), two.size());
  for (const auto& [id, row] : one)
    for (int d = 0; d < 3; ++d) EXPECT_EQ(row.x[d], two.at(id).x[d]) << "particle " << id;
}

TEST_F(Resize, ChangesASettledBedAndLeavesItCalm) {
  settle_and_save();
  struct Change {
    std::string name;
    Sizes left, right;
  };
  const std::vector<Change> changes{
      {"grown by half", {{0.0045, 0.006}, {89, 36}}, {{0.0045, 0.006}, {74, 44}}},  // as much volume
      {"twice as many", {{0.00238, 0.00317}, {600, 240}}, {{0.00238, 0.00317}, {500, 300}}},
      {"half as many", {{0.003, 0.004}, {150, 60}}, {{0.003, 0.004}, {125, 75}}},
      {"grown three times, a 27th as many", {{0.009, 0.012}, {11, 4}}, {{0.009, 0.012}, {9, 6}}},
      {"ten times as many", {{0.00139, 0.00186}, {3000, 1200}}, {{0.00139, 0.00186}, {2500, 1500}}},
      {"a tenth as many", {{0.00646, 0.00862}, {30, 12}}, {{0.00646, 0.00862}, {25, 15}}},
      {"one side moves to the other", {{0.003}, {200}}, {{0.003, 0.0045}, {350, 190}}}};
  for (const Change& change : changes) {
    SCOPED_TRACE(change.name);
    folder.write("population.json", population(change.left, change.right));
    ASSERT_EQ(
        run_deck(folder, machine("settled") + kResize + kDump + "run 1000\nunfix resize\n" + kTally + "run 500\n"), 0)
        << folder.read("err");

    const auto rows = first_dump(folder);
    expect_holds(rows, change.left, change.right);
    EXPECT_EQ(folder.read("out").find("largest overlap 0 ->"), std::string::npos);  // a bed, not a gas
    EXPECT_LE(largest_overlap(rows), 0.02 + 1e-6);
    const Counted counted(folder);
    EXPECT_LT(counted.windows.back().number_or("largest_overlap", 1), 0.1);
    const double mass = 1000.0 * (volume(change.left) + volume(change.right));
    EXPECT_LT(counted.windows.back().number_or("kinetic_energy_J", 1), mass * 9.81 * 0.01);  // that of a fall of 1 cm
    EXPECT_EQ(counted.total("lost"), 0.0);
    const auto report = json::read_file(folder / "resize.json");
    ASSERT_TRUE(report);
    EXPECT_NEAR((*report)["after"].number_or("volume_m3", 0), volume(change.left) + volume(change.right), 1e-12);
    EXPECT_LE(report->number_or("overlap_left", 1), 0.02);
    EXPECT_LT(report->number_or("largest_kinetic_energy_J", 1), mass * 9.81 * 0.01);
    const std::string said = folder.read("out");
    EXPECT_NE(said.find("granary/resize: [0, 0.03] m:"), std::string::npos);
    EXPECT_NE(said.find("largest overlap"), std::string::npos);
    EXPECT_NE(said.find("kinetic energy"), std::string::npos);
  }
}

// Ranks add forces up in another order, and a bed forgets how it began: counts agree as far as chance lets them.
TEST_F(Resize, AFallingBedCountsTheSameOnOneAndOnTwoRanks) {
  std::vector<double> collisions, impacts;
  for (int ranks : {1, 2}) {
    ASSERT_EQ(run_deck(folder, machine(kBox) + kResize + "run 3000\nunfix resize\n" + kTally + "run 3000\n", ranks), 0)
        << folder.read("err");
    const Counted counted(folder);
    collisions.push_back(counted.all_collisions());
    impacts.push_back(counted.impacts("w3") + counted.impacts("w4") + counted.impacts("paddle"));
    EXPECT_EQ(counted.total("lost"), 0.0);
  }
  EXPECT_GT(collisions[0], 500.0);
  EXPECT_GT(impacts[0], 50.0);
  EXPECT_NEAR(collisions[1], collisions[0], 3.0 * std::sqrt(2.0 * collisions[0]));
  EXPECT_NEAR(impacts[1], impacts[0], 3.0 * std::sqrt(2.0 * impacts[0]));
  RecordProperty("collisions", testing::PrintToString(collisions));
  RecordProperty("impacts", testing::PrintToString(impacts));
}

TEST_F(Resize, KeepsPlacesAndVelocitiesOfParticlesThatStayAsTheyAre) {
  settle_and_save();
  ASSERT_EQ(run_deck(folder, machine("settled") + kDump + "run 0\n"), 0) << folder.read("err");
  const auto before = first_dump(folder);
  std::map<bool, Sizes> now;  // exactly what is there
  for (const auto& [id, row] : before) {
    Sizes& sizes = now[row.x[0] >= kHalf];
    const double diameter = 2.0 * row.r;
    const auto at = std::find(sizes.diameters.begin(), sizes.diameters.end(), diameter);
    if (at != sizes.diameters.end())
      ++sizes.counts[static_cast<std::size_t>(at - sizes.diameters.begin())];
    else
      sizes.diameters.push_back(diameter), sizes.counts.push_back(1);
  }
  folder.write("population.json", population(now[false], now[true]));
  std::string resize = kResize;
  resize.insert(resize.size() - 1, " overlap 0.1");
  ASSERT_EQ(run_deck(folder, machine("settled") + resize + kDump + "run 0\n"), 0) << folder.read("err");
  const auto after = first_dump(folder);

  ASSERT_EQ(before.size(), after.size());
  for (const auto& [id, row] : before) {
    for (int d = 0; d < 3; ++d) {
      EXPECT_EQ(row.x[d], after.at(id).x[d]);
      EXPECT_EQ(row.v[d], after.at(id).v[d]);
    }
    EXPECT_EQ(row.r, after.at(id).r);
  }
}

TEST_F(Resize, RefusesAPopulationThatCannotFit) {
  folder.write("population.json", population({{0.004}, {3000}}, kRight));
  std::string resize = kResize;
  resize.insert(resize.size() - 1, " sweeps 100");
  EXPECT_EQ(run_deck(folder, machine(kBox) + resize + "run 0\n"), 2);
  EXPECT_NE(folder.read("err").find("do not fit between 0 m and 0.03 m"), std::string::npos) << folder.read("err");

  folder.write("population.json", "{}");
  EXPECT_EQ(run_deck(folder, machine(kBox) + kResize + "run 0\n"), 2);
  EXPECT_NE(folder.read("err").find("population.json"), std::string::npos) << folder.read("err");
}

}  // namespace
}  // namespace granary::dem::test
