// granary/wall over ranks and restarts, and what it refuses, with real LIGGGHTS.
#include "tests/liggghts/wall_deck.hpp"

namespace granary::dem::test {
namespace {

/// A bed in a turning drum with a baffle: rolling, sliding, crossing from rank to rank.
std::string drum_deck(const Law& law, const std::string& state = "-0.06 0.06 -0.06 0.06 -0.03 0.06") {
  return deck(law, state);
}
std::string drum_walls(const Law& law) {
  return ours(
      "cylinder drum 0 0 0.01 0 1 0 0.03 plane left 0 -0.01 0 0 1 0 plane right 0 0.01 0 0 1 0 mesh baffle baffle.stl "
      "rotate drum 0 0 0.01 0 1 0 rad/s -60 rotate baffle 0 0 0.01 0 1 0 rad/s -60",
      law);
}
std::string bed() {
  std::vector<TestParticle> list;
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 3; ++k)
        list.push_back({-0.0165 + 0.00411 * i + 1e-5 * k, -0.0071 + 0.00473 * j, -0.008 + 0.0047 * k, 0, 0, 0, 0.004});
  return particles(list);
}
const Law kDrumLaw{.models = "cohesion sjkr rolling_friction epsd2"};

void write_baffle(const Folder& folder) {
  folder.write("baffle.stl", stl(box({-0.029, -0.01, 0.009}, {-0.022, 0.01, 0.011}, 2)));
}

TEST(Wall, GivesTheSameOnTwoRanksAsOnOne) {
  const Folder folder;
  write_baffle(folder);
  Law law = kDrumLaw;
  const std::string end = bed() + print_vector(36) + run(3000, 300);
  const auto one = frames_of(folder, drum_deck(law) + drum_walls(law) + end);
  const auto values_of_one = read_vector(folder);
  law.more = "processors 2 1 1\n";
  const auto two = frames_of(folder, drum_deck(law) + drum_walls(law) + end, 2);
  const auto values_of_two = read_vector(folder);

  EXPECT_LT(difference(one, two), 1e-8);
  ASSERT_EQ(values_of_one.size(), values_of_two.size());
  const auto &a = values_of_one.rbegin()->second, &b = values_of_two.rbegin()->second;
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], 1e-4 * std::abs(a[k]) + 1e-7) << k;
  EXPECT_GT(a[7], 3.0);   // impacts on the baffle
  EXPECT_GT(a[34], 5.0);  // and on the drum
}

// The bed lies to the left of the middle of the box: without balance one rank would have it all.
TEST(Balance, GivesEachRankAsMuchAndChangesNothing) {
  const Folder folder;
  write_baffle(folder);
  Law law = kDrumLaw;
  const std::string box = "-0.03 0.09 -0.06 0.06 -0.03 0.06";
  const std::string end = bed() + "run 1\n" + run(1500, 300);
  const auto one = frames_of(folder, drum_deck(law, box) + drum_walls(law) + end);

  law.more = "processors 2 1 1\n";
  const auto two = frames_of(folder,
                             drum_deck(law, box) + drum_walls(law) +
                                 "fix balance all granary/balance every 2\nvariable uneven equal f_balance\n"
                                 "fix print all print 100 \"${uneven}\" file uneven.txt screen no\n" +
                                 end,
                             2);

  EXPECT_LT(difference(one, two), 1e-8);
  std::istringstream lines(folder.read("uneven.txt"));
  std::vector<double> uneven;
  for (std::string line; std::getline(lines, line);)
    if (!line.empty() && line[0] != '#') uneven.push_back(std::stod(line));
  ASSERT_GT(uneven.size(), 10u);
  EXPECT_LT(uneven.back(), 1.2);  // 108 particles; 2 where one rank has them all
}

// Slow enough to roll, its springs loaded but not at their limits, when the first new neighbour list finds it beyond
// the border at x = 0: what it remembers must go with it.
TEST(Wall, CarriesTheHistoryOfATouchFromRankToRank) {
  const Folder folder;
  Law law{.models = "rolling_friction epsd2"};
  const std::string end =
      ours("plane floor 0 0 0 0 0 1", law) +
      particles({{-0.0004, 0.001, 0.001999, 0.05, 0, 0, 0.004}, {0.0004, 0.02, 0.001999, -0.05, 0, 0, 0.004}}) +
      run(10000, 20);
  const auto one = frames_of(folder, deck(law) + end);
  law.more = "processors 2 1 1\n";
  const auto two = frames_of(folder, deck(law) + end, 2);
  EXPECT_LT(difference(one, two), 1e-14);
  EXPECT_GT(one.back().at(1).x[0], 0.0001);
}

TEST(Wall, GoesOnOverARestartAsIfThereHadBeenNone) {
  const Folder folder;
  write_baffle(folder);
  // The restart makes a new neighbour list; so does the uncut run there.
  const auto whole =
      frames_of(folder, drum_deck(kDrumLaw) + drum_walls(kDrumLaw) + bed() + "run 2000\n" + run(1000, 100));
  ASSERT_EQ(run_deck(folder, drum_deck(kDrumLaw) + drum_walls(kDrumLaw) + bed() + "run 2000\nwrite_restart middle\n"),
            0)
      << folder.read("err");
  const auto after = frames_of(folder, drum_deck(kDrumLaw, "middle") + drum_walls(kDrumLaw) + run(1000, 100));

  EXPECT_LT(difference(whole, after), 1e-12);
  EXPECT_GT(whole.back().size(), 100u);
}

TEST(Wall, RefusesARestartWithOtherBodies) {
  const Folder folder;
  folder.write("part.stl", stl(floor_of(2)));
  folder.write("other.stl", stl(floor_of(3)));
  const std::string past = "mesh part part.stl plane p 0 0 -0.02 0 0 1";
  ASSERT_EQ(run_deck(folder, deck({}) + ours(past) + falling() + "run 10\nwrite_restart middle\n"), 0);
  const auto goes_on = [&](const std::string& bodies) {
    return run_deck(folder, deck({}, "middle") + ours(bodies) + "run 1\n");
  };
  EXPECT_EQ(goes_on(past), 0) << folder.read("err");
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"mesh part other.stl plane p 0 0 -0.02 0 0 1", "shape of body 'part'"},
      {"mesh part part.stl plane p 0 0 -0.021 0 0 1", "shape of body 'p'"},
      {"mesh part part.stl plane q 0 0 -0.02 0 0 1", "the bodies part, p; the input script has part, q"},
      {"mesh part part.stl", "the input script has part."}};
  for (const auto& [bodies, said] : wrong) {
    EXPECT_EQ(goes_on(bodies), 2) << bodies;
    EXPECT_NE(folder.read("err").find(said), std::string::npos) << folder.read("err");
  }
}

TEST(Wall, SaysWhatIsWrongWithItsArguments) {
  const Folder folder;
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"mesh part nowhere.stl", "nowhere.stl"},
      {"mesh part cut.stl", "cut.stl"},
      {"plane p 0 0 0 0 0 0", "direction"},
      {"cylinder c 0 0 0 0 0 1 -1", "radius"},
      {"plane p 0 0 0 0 0 1 rotate q 0 0 0 0 0 1 rpm 3", "no body of that name"},
      {"plane p 0 0 0 0 0 1 rotate p 0 0 0 0 0 1 hertz 3", "rpm"},
      {"plane p 0 0 0 0 0 1 plane p 0 0 1 0 0 1", "two bodies"},
      {"plane p 0 0 0 0 0 1 rolling_friction epsd", "cdt"},
      {"plane p 0 0 0 0 0 1 push perhaps", "yes or no"},
      {"", "needs a body"}};
  folder.write("cut.stl", stl(floor_of(2)).substr(0, 300));
  for (const auto& [arguments, said] : wrong) {
    EXPECT_EQ(run_deck(folder, deck({}) + ours(arguments) + "run 1\n"), 2) << arguments;
    EXPECT_NE(folder.read("err").find(said), std::string::npos) << folder.read("err");
  }
  // A mesh that cannot be read is one problem, not three.
  EXPECT_EQ(run_deck(folder, deck({}) + ours("mesh part nowhere.stl rotate part 0 0 0 0 0 1 rpm 3") + "run 1\n"), 2);
  EXPECT_EQ(folder.read("err").find("body"), std::string::npos) << folder.read("err");
}

}  // namespace
}  // namespace granary::dem::test
