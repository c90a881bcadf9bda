// granary/bond in hard cases, with real LIGGGHTS: bonds far too stiff, a chopper far too fast, agglomerates against a
// blade from the start, none and all of the bonds broken.
#include <regex>

#include "tests/liggghts/bond_deck.hpp"

namespace granary::dem::test {
namespace {

/// Agglomerates of 37 spheres of 1.2 mm in a box.
struct Agglomerates {
  double normal_stiffness = 5e9, strength = 2e5, time_step = 2e-6, speed = 1.0;
  std::string gap = "6e-5", walls = "plane floor 0 0 0 0 0 1", where, more, after;

  std::string text() const {
    std::ostringstream text;
    text << bond_head(
                {.time_step = time_step, .young = 1e8, .skin = 0.0006, .state = "-0.06 0.06 -0.06 0.06 -0.002 0.06"})
         << "fix walls all granary/wall type 2 " << walls << "\nfix bonds all granary/bond normal_stiffness "
         << normal_stiffness << " shear_stiffness " << 0.458 * normal_stiffness << " tensile_strength " << strength
         << " shear_strength " << 0.563 * strength << " radius_scale 0.96 gap " << gap
         << " damping 0.1 fragments fragments.jsonl every 1000 breaks breaks.jsonl " << more << "\n"
         << "region space block -0.012 0.012 -0.012 0.012 0.0005 0.02 units box\n"
         << "fix fill all granary/agglomerates bond bonds density 1500 seed 5 "
         << (where.empty() ? "pack 37 1.2e-3 5e-3 count 6 region space walls walls" : where) << "\n"
         << kIntegrate << "fix gravity all gravity 9.81 vector 0 0 -1\nrun 0\nunfix fill\n"
         << "velocity all set NULL NULL " << -speed << " units box\n"
         << after;
    return text.str();
  }
};

double fastest(const std::vector<Frame>& frames) {
  double speed = 0.0;
  for (const auto& frame : frames)
    for (const auto& [tag, p] : frame) speed = std::max(speed, length(p.v));
  return speed;
}

TEST(Bond, RefusesATimeStepTooLongForStiffBondsAndRunsWithTheOneItNames) {
  const Folder folder;
  ASSERT_EQ(run_deck(folder, Agglomerates{.normal_stiffness = 5e11}.text()), 2);
  const std::string said = folder.read("err");
  std::smatch step;
  ASSERT_TRUE(std::regex_search(said, step, std::regex("Take a time step of ([0-9.e-]+) s"))) << said;
  const double named = std::stod(step[1]);
  EXPECT_LT(named, 1e-6);
  EXPECT_GT(named, 1e-7);

  // Not to break, so that what is too long would show: it gains energy without bound.
  const Folder stable;
  const auto frames = frames_of(
      stable,
      Agglomerates{.normal_stiffness = 5e11, .strength = 1e30, .time_step = named, .after = run(8000, 2000)}.text());
  EXPECT_LT(fastest(frames), 3.0);
  EXPECT_EQ(lines(stable, "fragments.jsonl").back()["broken"].as_integer(), 0);
}

TEST(Bond, BearsAChopperAt10000Rpm) {
  const Folder folder;
  folder.write("chopper.stl", stl(box({-0.011, -0.0006, 0.002}, {0.011, 0.0006, 0.012})));
  const auto frames = frames_of(
      folder, Agglomerates{.walls = "plane floor 0 0 0 0 0 1 cylinder shell 0 0 0 0 0 1 0.025 plane lid 0 0 0.05 0 0 1 "
                                    "mesh chopper chopper.stl rotate chopper 0 0 0 0 0 1 rpm 10000",
                           .after = run(15000, 3000)}
                  .text());
  ASSERT_EQ(frames.back().size(), 6u * 37u);
  EXPECT_LT(fastest(frames), 2.0 * 11.5);  // of its tip
  std::map<std::string, int> causes;
  for (const json::Value& line : lines(folder, "breaks.jsonl")) ++causes[line["cause"].as_string()];
  int all = 0;
  for (const auto& [cause, n] : causes) all += n;
  EXPECT_GT(all, 100);
  EXPECT_GT(causes["chopper"], all / 2);
  EXPECT_LT(causes["none"], all / 20);
}

TEST(Bond, BearsAnAgglomerateThatTouchesABladeFromTheStart) {
  // As in a file: two spheres lean by 3 % of their radius into a blade that turns towards them.
  const Folder folder;
  folder.write("blade.stl", stl(box({-0.011, -0.0006, 0.001}, {0.011, 0.0006, 0.012})));
  folder.write("touching.json", R"({"format": "granary-agglomerates-1", "agglomerates": [{"spheres_m":
      [[0.005, 0.001182, 0.006, 0.0006], [0.0062, 0.001182, 0.006, 0.0006],
       [0.0056, 0.001242, 0.00704, 0.0006], [0.0056, 0.002222, 0.00635, 0.0006]]}]})");
  const auto frames = frames_of(
      folder, Agglomerates{.strength = 1e7,
                           .speed = 0.0,
                           .walls = "plane floor 0 0 0 0 0 1 mesh blade blade.stl rotate blade 0 0 0 0 0 1 rpm 1000",
                           .where = "file touching.json",
                           .after = run(4000, 500)}
                  .text());
  EXPECT_LT(fastest(frames), 3.0);
  EXPECT_GT(frames.back().at(1).v[1], 0.1);
  EXPECT_EQ(lines(folder, "fragments.jsonl").back()["bonds"].as_integer(), 6);
}

TEST(Bond, PlacesAgglomeratesClearOfWalls) {
  const Folder folder;
  folder.write("blade.stl", stl(box({-0.011, -0.0006, 0.001}, {0.011, 0.0006, 0.012})));
  const auto frames = frames_of(
      folder,
      Agglomerates{.speed = 0.0, .walls = "plane floor 0 0 0 0 0 1 mesh blade blade.stl", .after = run(1, 1)}.text());
  ASSERT_EQ(frames.front().size(), 6u * 37u);
  for (const auto& [tag, p] : frames.front()) {
    const double out[3] = {std::abs(p.x[0]) - 0.011, std::abs(p.x[1]) - 0.0006, std::abs(p.x[2] - 0.0065) - 0.0055};
    EXPECT_GT(std::max({out[0], out[1], out[2]}), 0.0);
    EXPECT_GE(std::hypot(std::max(0.0, out[0]), std::max(0.0, out[1]), std::max(0.0, out[2])), 0.0006 - 1e-9);
  }
}

TEST(Bond, GoesOnWhenAllBondsAreBroken) {
  const Folder folder;
  frames_of(folder, Agglomerates{.strength = 1e-9, .after = run(6000, 3000)}.text());
  const json::Value last = lines(folder, "fragments.jsonl").back();
  EXPECT_EQ(last["bonds"].as_integer(), 0);
  EXPECT_EQ(last["breakage_ratio"].as_number(), 1.0);
  EXPECT_EQ(last["fragments"].as_integer(), 6 * 37);
  EXPECT_NEAR(last["d50_m"].as_number(), 1.2e-3, 1e-12);
  EXPECT_NEAR(last["d50_hull_m"].as_number(), 1.2e-3, 1e-12);
}

TEST(Bond, RunsWithoutASingleBond) {
  const Folder folder;
  frames_of(folder,
            Agglomerates{
                .gap = "0", .where = "pack 37 1.2e-3 9e-3 count 2 region space walls walls", .after = run(2000, 1000)}
                .text());
  const json::Value last = lines(folder, "fragments.jsonl").back();
  EXPECT_EQ(last["bonds"].as_integer(), 0);
  EXPECT_EQ(last["breakage_ratio"].as_number(), 0.0);
  EXPECT_TRUE(lines(folder, "breaks.jsonl").empty());
}

TEST(Bond, TheExampleOfTheDocumentationRuns) {
  const Folder folder;
  ASSERT_EQ(shell(folder, program() + " -in " + GRANARY_SOURCE_DIR + "/tests/liggghts/data/one_agglomerate.liggghts"),
            0)
      << folder.read("err");
  EXPECT_EQ(lines(folder, "fragments.jsonl").size(), 7u);
  EXPECT_GT(lines(folder, "breaks.jsonl").size(), 5u);
}

}  // namespace
}  // namespace granary::dem::test
