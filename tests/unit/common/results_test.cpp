#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "common/results/hdf5_file.hpp"

namespace granary {
namespace {
namespace fs = std::filesystem;

fs::path scratch(const std::string& name) {
  const fs::path folder = fs::temp_directory_path() / ("granary_hdf5_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  return folder / name;
}

TEST(Hdf5File, ReadsBackWhatItWrote) {
  const fs::path path = scratch("a.h5");
  {
    auto file = Hdf5File::create(path).value();
    ASSERT_TRUE(file.write("/dem/rate", {{2, 2}, {1.0, 2.0, 3.0, 4.0}}, "1/s", "rates"));
    ASSERT_TRUE(file.write_texts("/names", {"shell", "impeller µ"}, "bodies"));
    ASSERT_TRUE(file.attribute("/", "format", "granary-test"));
    ASSERT_TRUE(file.attribute("/dem", "seed", 7.0));
  }
  const auto file = Hdf5File::open(path).value();
  const auto rate = file.read("/dem/rate").value();
  EXPECT_EQ((std::vector<std::size_t>{2, 2}), rate.shape);
  EXPECT_EQ((std::vector<double>{1.0, 2.0, 3.0, 4.0}), rate.values);
  EXPECT_EQ((std::vector<std::string>{"shell", "impeller µ"}), file.read_texts("/names").value());
  EXPECT_EQ("granary-test", file.text_attribute("/", "format").value());
  EXPECT_EQ("1/s", file.text_attribute("/dem/rate", "unit").value());
  EXPECT_EQ(7.0, file.number_attribute("/dem", "seed").value());
  EXPECT_THAT(file.children("/").value(), testing::UnorderedElementsAre("dem", "names"));
}

TEST(Hdf5File, GrowsRowByRowAndCanBeCutBack) {
  const fs::path path = scratch("rows.h5");
  {
    auto file = Hdf5File::create(path).value();
    ASSERT_TRUE(file.create_growing("/state/number", {2}, "1", "particles"));
    ASSERT_TRUE(file.create_growing("/state/time", {}, "s", "time"));
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(file.append_row("/state/number", {double(i), double(10 * i)}));
      ASSERT_TRUE(file.append_row("/state/time", {0.2 * i}));
    }
  }
  auto file = Hdf5File::open_to_append(path).value();
  ASSERT_TRUE(file.truncate_rows("/state/number", 2));
  EXPECT_EQ((std::vector<std::size_t>{2, 2}), file.read("/state/number").value().shape);
  EXPECT_EQ((std::vector<double>{1.0, 10.0}), file.read_row("/state/number", 1).value());
  EXPECT_FALSE(file.read_row("/state/number", 2));
  EXPECT_EQ(3u, file.read("/state/time").value().values.size());
}

TEST(Hdf5File, SaysWhatIsMissing) {
  EXPECT_THAT(Hdf5File::open(scratch("none.h5")).error().message, testing::HasSubstr("there is no such file"));
  const fs::path path = scratch("empty.h5");
  const auto file = Hdf5File::create(path).value();
  EXPECT_THAT(file.read("/state/number").error().message, testing::HasSubstr("\"/state/number\" is missing"));
}

}  // namespace
}  // namespace granary
