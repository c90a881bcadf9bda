// granary/bond and granary/agglomerates over ranks and restarts, what they refuse, and a brick that falls on a plate.
#include "tests/liggghts/bond_deck.hpp"

namespace granary::dem::test {
namespace {

/// A brick of 6 x 4 x 4 spheres falls on a floor, its corner first.
struct Brick {
  std::string state = BondBox{}.state, more, files = "fragments fragments.jsonl every 500 breaks breaks.jsonl";
  int seed = 3;

  std::string text() const {
    Bonds bonds{.tensile_strength = 5e4, .shear_strength = 3e4, .damping = 0.05};
    bonds.more = "among group gap 2e-4 weibull 4 seed " + std::to_string(seed) + " " + files;
    std::string all = bond_head({.state = state, .more = more}) +
                      "fix walls all granary/wall type 2 plane floor 0 0 -0.025 0.1 0.05 1\n" + bonds.fix() +
                      kIntegrate + "fix gravity all gravity 9.81 vector 0 0 -1\n";
    if (state.find(' ') == std::string::npos) return all;
    std::vector<TestParticle> list;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 4; ++k)
          list.push_back({(i - 2.4) * kSpacing, (j - 1.5) * kSpacing, -0.02 + k * kSpacing, 0.1, 0, -2, 2 * kRadius});
    return all + particles(list);
  }
};

std::vector<std::string> told(const Folder& folder) {
  return {folder.read("fragments.jsonl"), folder.read("breaks.jsonl")};
}

/// The same apart from the last digits of numbers.
void expect_alike(const json::Value& a, const json::Value& b, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  if (a.is_object()) {
    for (const auto& [key, value] : a.members()) expect_alike(value, b[key], tolerance);
  } else if (a.is_array()) {
    for (std::size_t k = 0; k < a.size(); ++k) expect_alike(a.items()[k], b.items()[k], tolerance);
  } else if (a.is_number() && !a.is_integer()) {
    EXPECT_NEAR(a.as_number(), b.as_number(), tolerance * std::abs(a.as_number()) + 1e-12);
  } else {
    EXPECT_TRUE(a == b);
  }
}

void expect_same_story(const Folder& a, const Folder& b, double tolerance) {
  for (const char* file : {"fragments.jsonl", "breaks.jsonl"}) {
    const auto ours = lines(a, file), theirs = lines(b, file);
    ASSERT_EQ(ours.size(), theirs.size()) << file;
    for (std::size_t k = 0; k < ours.size(); ++k) expect_alike(ours[k], theirs[k], tolerance);
  }
}

TEST(Bond, ABrickThatFallsOnAPlateBreaksTheSameWayForTheSameSeed) {
  const Folder once, again, other;
  ASSERT_EQ(run_deck(once, Brick{}.text() + "run 4000\n"), 0) << once.read("err");
  ASSERT_EQ(run_deck(again, Brick{}.text() + "run 4000\n"), 0);
  ASSERT_EQ(run_deck(other, Brick{.seed = 4}.text() + "run 4000\n"), 0);
  EXPECT_EQ(told(once), told(again));
  EXPECT_NE(told(once), told(other));

  const auto samples = lines(once, "fragments.jsonl"), breaks = lines(once, "breaks.jsonl");
  ASSERT_EQ(samples.size(), 9u);
  const json::Value &first = samples.front(), &last = samples.back();
  EXPECT_EQ(first["fragments"].as_integer(), 1);
  EXPECT_EQ(first["bonds"].as_integer(), 5 * 16 + 2 * 6 * 12);
  EXPECT_GT(last["fragments"].as_integer(), 3);
  EXPECT_EQ(last["bonds"].as_integer() + last["broken"].as_integer(), first["bonds"].as_integer());
  EXPECT_EQ(last["broken"].as_integer(), static_cast<std::int64_t>(breaks.size()));
  EXPECT_EQ(last["agglomerate_breakage_ratio"].as_number(), 1.0);
  EXPECT_LT(last["d50_hull_m"].as_number(), first["d50_hull_m"].as_number());

  // Splits, followed from sample to sample, lead from the sizes of one to those of the next.
  std::map<std::int64_t, std::int64_t> sizes{{96, 1}};
  std::map<std::string, int> causes;
  for (const json::Value& sample : samples) {
    for (const json::Value& split : sample["splits"].items()) {
      --sizes[split["parent"].as_integer()];
      for (const json::Value& daughter : split["daughters"].items()) ++sizes[daughter.as_integer()];
      ++causes[split["cause"].as_string()];
    }
    std::erase_if(sizes, [](const auto& entry) { return entry.second == 0; });
    std::map<std::int64_t, std::int64_t> said;
    for (const json::Value& row : sample["sizes"].items())
      said[row.items()[0].as_integer()] = row.items()[1].as_integer();
    EXPECT_EQ(sizes, said);
  }
  EXPECT_GT(causes["floor"], 0);
  EXPECT_GE(causes["floor"], causes["particles"] + causes["none"]);
}

// The state of two ranks goes on on one.
TEST(Bond, GivesTheSameOnTwoRanksAsOnOne) {
  const Folder one, two;
  const std::string end = run(400, 100) + "write_restart middle\n";
  const auto alone = frames_of(one, Brick{}.text() + end);
  const auto shared = frames_of(two, Brick{.more = "processors 2 1 1\n"}.text() + end, 2);
  EXPECT_LT(difference(alone, shared), 1e-9);

  const Brick goes_on{.state = "middle"};
  EXPECT_LT(difference(frames_of(one, goes_on.text() + run(400, 100)), frames_of(two, goes_on.text() + run(400, 100))),
            1e-6);
  EXPECT_GT(lines(one, "breaks.jsonl").size(), 10u);
  expect_same_story(one, two, 1e-6);
}

TEST(Bond, GoesOnOverARestartAsIfThereHadBeenNone) {
  const Folder whole, cut;
  // The restart makes a new neighbour list; so does the uncut run there.
  const auto uncut = frames_of(whole, Brick{}.text() + "run 1000\n" + run(1000, 100));
  ASSERT_EQ(run_deck(cut, Brick{}.text() + "run 1000\nwrite_restart middle\n"), 0) << cut.read("err");
  const auto after = frames_of(cut, Brick{.state = "middle"}.text() + run(1000, 100));
  EXPECT_LT(difference(uncut, after), 1e-10);
  EXPECT_GT(lines(whole, "breaks.jsonl").size(), 10u);
  expect_same_story(whole, cut, 1e-9);
}

TEST(Bond, HoldsAcrossAPeriodicBoundary) {
  // A rod through the boundary, thrown along it: nothing but its place may change.
  std::vector<TestParticle> list;
  for (int i = 0; i < 5; ++i) list.push_back({0.05 + i * kSpacing - (i > 2 ? 0.12 : 0.0), 0, 0, 1, 0, 0, 2 * kRadius});
  const Folder folder;
  Bonds bonds;
  bonds.more += " fragments fragments.jsonl every 1000";
  const auto frames = frames_of(
      folder, bond_head({.boundary = "p f f"}) + bonds.fix() + particles(list) + kIntegrate + run(20000, 20000));
  const auto samples = lines(folder, "fragments.jsonl");
  EXPECT_EQ(samples.back()["bonds"].as_integer(), 4);
  EXPECT_NEAR(samples.back()["d50_hull_m"].as_number(), samples.front()["d50_hull_m"].as_number(), 1e-9);
  for (const auto& [tag, p] : frames.back()) EXPECT_LT(length(p.force), 1e-6);
}

TEST(Bond, SaysWhenABondReachesFartherThanRanksTellEachOther) {
  const Folder folder;
  const std::string deck = bond_head({.time_step = 2e-5, .more = "processors 2 1 1\n"}) + Bonds{}.fix() + chain(1) +
                           "fix stay clamped move linear -10 0 0\nfix pull tip move linear 10 0 0\nrun 200\n";
  EXPECT_EQ(run_deck(folder, deck, 2), 2);
  EXPECT_NE(folder.read("err").find("reaches farther than the ranks tell each other"), std::string::npos)
      << folder.read("err");
}

TEST(Bond, LeavesWithItsParticle) {
  const Folder folder;
  Bonds bonds;
  bonds.more += " fragments fragments.jsonl every 1000 breaks breaks.jsonl";
  ASSERT_EQ(run_deck(folder, bond_head({.time_step = 2e-5}) + bonds.fix() + chain(5) + kIntegrate +
                                 "velocity all set 1 NULL NULL units box\nregion end block 0.03 0.06 INF INF INF INF "
                                 "units box\nfix outlet all granary/outlet region end\n"
                                 "thermo_modify lost ignore norm no\nrun 1000\n"),
            0)
      << folder.read("err");
  const json::Value last = lines(folder, "fragments.jsonl").back();
  EXPECT_LT(last["bonds"].as_integer(), 4);
  EXPECT_GT(last["bonds"].as_integer(), 0);
  EXPECT_EQ(last["broken"].as_integer(), 0);
  EXPECT_EQ(last["fragments"].as_integer(), 1);
  EXPECT_EQ(last["splits"].size(), 0u);
  EXPECT_TRUE(lines(folder, "breaks.jsonl").empty());
}

TEST(Bond, AreMadeAtTheTimeAskedFor) {
  // Eight spheres that fly apart: no bond holds them for long.
  const Folder folder;
  Bonds bonds{.tensile_strength = 1e3, .shear_strength = 1e3};
  bonds.more += " create 1e-3 fragments fragments.jsonl every 100 breaks breaks.jsonl";
  ASSERT_EQ(run_deck(folder, bond_head({}) + bonds.fix() + cube(2, 0.1) + kIntegrate + "run 400\n"), 0)
      << folder.read("err");
  const auto samples = lines(folder, "fragments.jsonl");
  EXPECT_EQ(samples[1]["bonds"].as_integer(), 0);
  EXPECT_EQ(samples[2]["bonds"].as_integer(), 12);
  EXPECT_EQ(samples[2]["step"].as_integer(), 200);
  const auto breaks = lines(folder, "breaks.jsonl");
  ASSERT_GT(breaks.size(), 3u);
  EXPECT_EQ(breaks[0]["fragment_spheres"].as_integer(), 8);
}

TEST(Bond, SaysWhatIsWrong) {
  const Folder folder;
  const auto says = [&](const std::string& deck, const std::string& said) {
    EXPECT_EQ(run_deck(folder, deck), 2) << said;
    EXPECT_NE(folder.read("err").find(said), std::string::npos) << folder.read("err");
  };
  const auto bonds = [](const std::string& more) {
    return bond_head({}) + Bonds{.more = more}.fix() + chain(2) + kIntegrate + "run 1\n";
  };
  says(bonds("gap 1e-4 among all"), "'among' is 'all'; it must be agglomerates or group.");
  says(bonds("gap 1e-4 weibull 3 normal 0.1"), "exclude each other");
  says(bonds("gap 1e-4 radius 0.001"), "'radius' and 'radius_scale' exclude");
  says(bonds("gap 1e-4 fragments f.jsonl"), "needs the keyword 'every'");
  says(bonds("among group"), "needs the keyword 'gap'");
  says(bonds("gap 0.002 among group"), "Take a 'neighbor' of at least the gap");
  const std::string box = "region box2 block -0.02 0.02 -0.02 0.02 -0.02 0.02 units box\n";
  const auto agglomerates = [&](const std::string& more) {
    return bond_head({}) + Bonds{.more = "gap 1e-4"}.fix() + box + "fix a all granary/agglomerates density 1000 " +
           more + "\n" + kIntegrate + "run 1\n";
  };
  says(agglomerates("bond bonds pack 10 1e-3 3e-3"), "'pack' needs a 'region' and a 'count'");
  says(agglomerates("bond bonds pack 10 1e-3 3e-3 region nowhere count 1"), "there is no region 'nowhere'");
  says(agglomerates("bond glue pack 10 1e-3 3e-3 region box2 count 1"), "there is no fix granary/bond 'glue'");
  says(agglomerates("bond bonds file nothing.json"), "nothing.json");
  says(agglomerates("bond bonds pack 10 4e-3 11e-3 region box2 count 500"), "there is room for");
}

}  // namespace
}  // namespace granary::dem::test
