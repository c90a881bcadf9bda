// The wear that granary/wall keeps, held against slides and impacts worked out by hand, with real LIGGGHTS.
#include <algorithm>
#include <numeric>

#include "tests/liggghts/wall_deck.hpp"

namespace granary::dem::test {
namespace {

const std::string kWear = " wear_archard 1e-4 2e9 wear_finnie 3e-11 wear_file worn 0";

/// The cell data of that name of a legacy VTK file.
std::vector<double> cell_data(const Folder& folder, const std::string& file, const std::string& name) {
  std::istringstream text(folder.read(file));
  std::vector<double> values;
  std::size_t n = 0;
  for (std::string word; text >> word;) {
    if (word == "CELL_DATA") text >> n;
    if (word != name) continue;
    for (int k = 0; k < 4; ++k) text >> word;  // double 1 LOOKUP_TABLE default
    for (double value; values.size() < n && text >> value;) values.push_back(value);
  }
  EXPECT_GT(n, 0u) << file;
  EXPECT_EQ(values.size(), n) << file << " " << name;
  return values;
}
double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

// A sphere slides down a slope: F_n = m g cos, its surface slips at (g sin - 7/2 mu g cos) t.
TEST(WallWear, TakesOffWhatArchardSaysOverASlide) {
  const Folder folder;
  const double slope = 20 * kPi / 180, sine = std::sin(slope), cosine = std::cos(slope);
  folder.write("slope.stl",
               stl(sheet({-0.05 * cosine, -0.05, 0.05 * sine}, {0.1 * cosine, 0, -0.1 * sine}, {0, 0.1, 0}, 10)));
  const Law law{.friction = 0.05};
  const double weight = kMass * law.gravity * cosine;
  const double overlap = std::cbrt(std::pow(weight / (4.0 / 3.0 * effective_young() * std::sqrt(kRadius)), 2));
  const double off = kRadius - overlap, x0 = -0.02;
  const int steps = 16000;
  ASSERT_EQ(
      run_deck(folder,
               deck(law) + ours("mesh slope slope.stl" + kWear, law) +
                   particles({{x0 * cosine + off * sine, 0.0031, -x0 * sine + off * cosine, 0, 0, 0, 2 * kRadius}}) +
                   "run " + std::to_string(steps) + "\n"),
      0)
      << folder.read("err");

  const std::string file = "worn_slope_" + std::to_string(steps) + ".vtk";
  const auto volumes = cell_data(folder, file, "volume_by_sliding_m3"),
             depths = cell_data(folder, file, "depth_by_sliding_m");
  const double time = steps * kTimeStep, way = 0.5 * law.gravity * (sine - 3.5 * law.friction * cosine) * time * time;
  const double expected = 1e-4 / 2e9 * weight * way;
  std::cout << "    Archard over a slide [m3]: expected " << expected << ", got " << sum(volumes) << "\n";
  EXPECT_NEAR(sum(volumes), expected, 0.005 * expected);
  const auto worn = std::count_if(volumes.begin(), volumes.end(), [](double v) { return v > 0.0; });
  EXPECT_GE(worn, 2);   // the squares that it came through
  EXPECT_LE(worn, 10);  // of 200
  const double area = 0.5 * 0.01 * 0.01;
  for (std::size_t t = 0; t < volumes.size(); ++t) EXPECT_NEAR(depths[t], volumes[t] / area, 1e-6 * depths[t]);
  EXPECT_EQ(sum(cell_data(folder, file, "volume_by_impacts_m3")), 0.0);  // it touched when the run began
}

// One impact on each of some squares, at an angle of its own to the surface.
TEST(WallWear, TakesOffWhatFinnieSaysAtEveryAngle) {
  const Folder folder;
  folder.write("floor.stl", stl(floor_of(10)));
  const std::vector<double> angles{5, 10, 18, 19, 30, 45, 60, 80, 90};
  const double speed = 2.0;
  std::vector<TestParticle> list;
  std::vector<double> expected;
  for (std::size_t k = 0; k < angles.size(); ++k) {
    const double a = angles[k] * kPi / 180, gap = 2e-6;
    const double hit = -0.045 + 0.01 * static_cast<double>(k);  // in the middle of a square
    list.push_back({hit - gap / std::tan(a) - 0.0011, hit + 0.0021, kRadius + gap, speed * std::cos(a), 0,
                    -speed * std::sin(a), 2 * kRadius});
    const double f =
        std::tan(a) <= 1.0 / 3.0 ? std::sin(2 * a) - 3 * std::pow(std::sin(a), 2) : std::pow(std::cos(a), 2) / 3;
    expected.push_back(3e-11 * kMass * speed * speed * f);
  }
  const Law law{.gravity = 0.0};
  ASSERT_EQ(run_deck(folder, deck(law) + ours("mesh floor floor.stl" + kWear, law) + particles(list) + "run 1000\n"), 0)
      << folder.read("err");

  auto volumes = cell_data(folder, "worn_floor_1000.vtk", "volume_by_impacts_m3");
  std::erase_if(volumes, [](double v) { return v == 0.0; });
  std::erase_if(expected, [](double v) { return v < 1e-40; });  // 90 degrees
  std::sort(volumes.begin(), volumes.end());
  std::sort(expected.begin(), expected.end());
  std::erase_if(volumes, [](double v) { return v < 1e-40; });
  ASSERT_EQ(volumes.size(), expected.size());
  for (std::size_t k = 0; k < volumes.size(); ++k) EXPECT_NEAR(volumes[k], expected[k], 1e-6 * expected[k]);
  EXPECT_EQ(volumes.size(), 8u);
}

// On a body that turns, over an interval, over ranks and over a restart.
TEST(WallWear, IsTheSameOverRanksAndRestarts) {
  const Folder folder;
  folder.write("paddle.stl", stl(paddle()));
  Law law{.restitution = 0.7};
  const std::string walls = ours(
      "mesh part paddle.stl rotate part 0 0 0 0 0 1 rad/s 100 mesh floor floor.stl cylinder drum 0 0 0 0 0 1 0.055"
      " wear_archard 1e-4 2e9 wear_finnie 3e-11 wear_file worn 1000",
      law);
  folder.write("floor.stl", stl(sheet({-0.055, -0.055, -0.0062}, {0.11, 0, 0}, {0, 0.11, 0}, 6)));
  const auto all = [&] {
    std::vector<double> values;
    for (const std::string body : {"part", "floor"})
      for (const std::string name : {"volume_by_sliding_m3", "volume_by_impacts_m3"})
        for (const double v : cell_data(folder, "worn_" + body + "_3000.vtk", name)) values.push_back(v);
    fs::remove(folder / "worn_part_3000.vtk");
    fs::remove(folder / "worn_floor_3000.vtk");
    return values;
  };
  ASSERT_EQ(run_deck(folder, deck(law) + walls + before_the_paddle() + "run 1500\nrun 1500\n"), 0)
      << folder.read("err");
  for (const std::string step : {"1000", "1500", "2000"})
    EXPECT_TRUE(fs::exists(folder / ("worn_part_" + step + ".vtk"))) << step;
  EXPECT_FALSE(fs::exists(folder / "worn_drum_1000.vtk"));
  const auto whole = all();
  EXPECT_GT(std::count_if(whole.begin(), whole.end(), [](double v) { return v > 0.0; }), 10);

  ASSERT_EQ(run_deck(folder, deck(law) + walls + before_the_paddle() + "run 1500\nwrite_restart middle\n"), 0);
  ASSERT_EQ(run_deck(folder, deck(law, "middle") + walls + "run 1500\n"), 0) << folder.read("err");
  const auto restarted = all();
  law.more = "processors 2 1 1\n";
  ASSERT_EQ(run_deck(folder, deck(law, "middle") + walls + "run 1500\n", 2), 0) << folder.read("err");
  const auto on_two = all();
  ASSERT_EQ(restarted.size(), whole.size());
  ASSERT_EQ(on_two.size(), whole.size());
  const double largest = *std::max_element(whole.begin(), whole.end());
  for (std::size_t k = 0; k < whole.size(); ++k) {
    EXPECT_NEAR(restarted[k], whole[k], 1e-6 * largest);
    EXPECT_NEAR(on_two[k], whole[k], 1e-6 * largest);
  }
}

TEST(WallWear, SaysWhatItNeeds) {
  const Folder folder;
  folder.write("floor.stl", stl(floor_of(1)));
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"plane p 0 0 0 0 0 1 wear_finnie 1e-11 wear_file worn 0", "needs a 'mesh'"},
      {"mesh floor floor.stl wear_finnie 1e-11", "need each other"},
      {"mesh floor floor.stl wear_file worn 10", "need each other"},
      {"mesh floor floor.stl wear_finnie 1e-11 wear_file worn often", "number of steps"},
      {"mesh floor floor.stl wear_archard 1e-4 0 wear_file worn 0", "wear_archard"}};
  for (const auto& [arguments, said] : wrong) {
    EXPECT_EQ(run_deck(folder, deck({}) + ours(arguments) + "run 1\n"), 2) << arguments;
    EXPECT_NE(folder.read("err").find(said), std::string::npos) << folder.read("err");
  }
}

}  // namespace
}  // namespace granary::dem::test
