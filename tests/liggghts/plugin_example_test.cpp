// The script that docs/dem_styles.md shows new users, run as it stands.
#include "tests/liggghts/plugin_deck.hpp"

namespace granary::dem::test {
namespace {

void run_example(const Folder& folder, int ranks) {
  fs::copy(fs::path(GRANARY_SOURCE_DIR) / "tests/liggghts/data/drum", folder.path());
  ASSERT_EQ(shell(folder, (ranks > 1 ? mpirun(ranks) : std::string()) + program() + " -in in.drum"), 0)
      << folder.read("err");
}

/// Sum of a VTK file's cell data of that name; each of its `cells` must have a value.
double sum_of(const Folder& folder, const std::string& file, const std::string& name, int cells) {
  std::istringstream words(folder.read(file));
  std::string word;
  while (words >> word && word != name) continue;
  words >> word >> word >> word >> word;  // double 1 LOOKUP_TABLE default
  double sum = 0.0, value = 0.0;
  for (int k = 0; k < cells; ++k) {
    EXPECT_TRUE(words >> value) << file << ": " << name << " of cell " << k;
    sum += value;
  }
  return sum;
}

TEST(Example, TheDrumOfTheDocumentationMeasuresLoadsImpactsAndWear) {
  const Folder folder;
  run_example(folder, 1);

  const Counted counted(folder);
  ASSERT_EQ(counted.windows.size(), 5u);
  EXPECT_EQ(counted.total("lost"), 0.0);
  for (const char* body : {"blade", "beater", "drum", "floor"}) EXPECT_GT(counted.impacts(body), 0.0) << body;
  EXPECT_GT(counted.windows.back()["loads"]["blade"].number_or("power_W", 0.0), 0.0) << "the blade drives the bed";
  for (const char* quantity : {"volume_by_sliding_m3", "volume_by_impacts_m3"})
    EXPECT_GT(sum_of(folder, "wear_blade_14000.vtk", quantity, 12), 0.0) << quantity;
}

TEST(Example, TheDrumOfTheDocumentationBeginsTheSameOnTwoRanks) {
  const Folder one, two;
  run_example(one, 1);
  run_example(two, 2);

  const Counted alone(one), shared(two);
  ASSERT_FALSE(alone.windows.empty());
  ASSERT_FALSE(shared.windows.empty());
  // The first line only: thousands of contacts later round-off has grown to another course.
  for (const char* key : {"collisions", "impacts"})
    EXPECT_EQ(alone.windows.front()[key], shared.windows.front()[key]) << key;
}

}  // namespace
}  // namespace granary::dem::test
