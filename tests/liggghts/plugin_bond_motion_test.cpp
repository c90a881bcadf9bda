// What bonded bodies of granary/bond keep while they move: no force from turning, energy, momentum. Real LIGGGHTS.
#include "tests/liggghts/bond_deck.hpp"

namespace granary::dem::test {
namespace {

TEST(Bond, ABodyThatTurnsAsOneFeelsNoForce) {
  // About a skew axis, 20 turns at 10 000 rpm, prescribed: every force there is comes from the bonds.
  const Folder folder;
  const BondBox box{.time_step = 2e-6};
  const auto frames =
      frames_of(folder, bond_head(box) + Bonds{.damping = 0.5}.fix() + cube(3, 0.0) +
                            "fix turn all move rotate 0.002 -0.001 0.003 1 2 3 0.006\n" + run(60000, 6000));
  double largest = 0.0;
  for (const Frame& frame : frames)
    for (const auto& [tag, p] : frame) largest = std::max(largest, length(p.force));
  EXPECT_GT(length(frames.back().at(1).v), 4.0);
  // Of the force that would stretch a bond by its own length.
  EXPECT_LT(largest / (kNormal * kArea * kSpacing), 1e-9);
}

TEST(Bond, KeepsEnergyWithoutDamping) {
  const auto drift = [](double time_step, int steps) {
    const Folder folder;
    const BondBox box{.time_step = time_step};
    EXPECT_EQ(run_deck(folder, bond_head(box) + Bonds{}.fix() + cube(3, 0.05) + kIntegrate +
                                   "compute spin all erotate/sphere\n" + print({"ke", "c_spin", "f_bonds[3]"}, 10) +
                                   "run " + std::to_string(steps) + "\n"),
              0)
        << folder.read("err");
    const auto rows = read_printed(folder);
    const auto total = [](const std::vector<double>& row) { return row[0] + row[1] + row[2]; };
    const double start = total(rows.front());
    double farthest = 0.0, elastic = 0.0, early = 0.0, late = 0.0;
    const std::size_t tenth = rows.size() / 10;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      farthest = std::max(farthest, std::abs(total(rows[k]) / start - 1.0));
      elastic = std::max(elastic, rows[k][2] / start);
      if (k < tenth) early += total(rows[k]) / static_cast<double>(tenth);
      if (k + tenth >= rows.size()) late += total(rows[k]) / static_cast<double>(tenth);
    }
    EXPECT_GT(elastic, 0.2);
    EXPECT_LT(farthest, 0.005);
    return std::abs(late / early - 1.0);
  };
  EXPECT_LT(drift(5e-6, 40000), 5e-5);
}

// Contacts would take some too: it ends before pieces meet. A bond is missed from one step to the next, so the balance
// closes with the time step.
TEST(Bond, EnergyThatBreakingTakesIsThatOfTheBrokenBonds) {
  const auto missing = [](double time_step) {
    const Folder folder;
    EXPECT_EQ(run_deck(folder, bond_head({.time_step = time_step}) +
                                   Bonds{.tensile_strength = 1.5e3, .shear_strength = 1.2e3}.fix() + cube(3, 0.05) +
                                   kIntegrate + "compute spin all erotate/sphere\n" +
                                   print({"ke", "c_spin", "f_bonds[3]", "f_bonds[4]", "f_bonds[2]"}, 10) + "run " +
                                   std::to_string(std::lround(8e-4 / time_step)) + "\n"),
              0)
        << folder.read("err");
    const auto rows = read_printed(folder);
    const auto total = [](const std::vector<double>& row) { return row[0] + row[1] + row[2] + row[3]; };
    EXPECT_GT(rows.back()[4], 10.0);
    EXPECT_GT(rows.back()[3], 0.02 * total(rows.front()));
    return std::abs(total(rows.back()) / total(rows.front()) - 1.0);
  };
  const double coarse = missing(1e-6), fine = missing(2.5e-7);
  EXPECT_LT(fine, 2e-3);
  EXPECT_LT(fine, 0.5 * coarse);
}

TEST(Bond, DampingOnlyTakesEnergy) {
  const Folder folder;
  ASSERT_EQ(run_deck(folder, bond_head({}) + Bonds{.damping = 0.1}.fix() + cube(3, 0.05) + kIntegrate +
                                 "compute spin all erotate/sphere\n" + print({"ke", "c_spin", "f_bonds[3]"}, 20) +
                                 "run 4000\n"),
            0)
      << folder.read("err");
  const auto rows = read_printed(folder);
  double last = 1e9;
  for (const auto& row : rows) {
    const double now = row[0] + row[1] + row[2];
    EXPECT_LT(now, last * 1.002);
    last = now;
  }
  EXPECT_LT(last, 0.3 * (rows.front()[0] + rows.front()[1] + rows.front()[2]));
}

TEST(Bond, KeepsMomentumAndAngularMomentumAlsoWhileBreaking) {
  const Folder folder;
  Bonds bonds{.tensile_strength = 1.5e3, .shear_strength = 1.2e3, .damping = 0.1};
  bonds.more += " breaks breaks.jsonl";
  const auto frames = frames_of(folder, bond_head({}) + bonds.fix() + cube(3, 0.05) + kIntegrate + run(8000, 500));
  const auto momenta = [](const Frame& frame) {
    std::array<double, 6> sum{};
    for (const auto& [tag, p] : frame) {
      const Point orbit = cross(p.x, p.v);
      for (std::size_t d = 0; d < 3; ++d) {
        sum[d] += kMass * p.v[d];
        sum[3 + d] += kMass * orbit[d] + kInertia * p.spin[d];
      }
    }
    return sum;
  };
  const auto n_broken = lines(folder, "breaks.jsonl").size();
  EXPECT_GT(n_broken, 5u);
  EXPECT_LT(n_broken, 54u);
  const auto before = momenta(frames.front()), after = momenta(frames.back());
  for (std::size_t d = 0; d < 3; ++d) {
    EXPECT_NEAR(before[d], after[d], 1e-13 * 27 * kMass * 0.05 + 1e-18);
    EXPECT_NEAR(before[3 + d], after[3 + d], 1e-12 * 27 * kMass * 0.05 * kSpacing + 1e-21);
  }
}

}  // namespace
}  // namespace granary::dem::test
