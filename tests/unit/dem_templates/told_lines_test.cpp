// What a run that goes on from a state makes of what was told after it.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "common/files.hpp"
#include "dem_templates/plugin/tally/told_lines.hpp"

namespace granary::dem {
namespace {

struct ToldLines : testing::Test {
  std::string file = testing::TempDir() + "told_" + std::to_string(getpid()) + ".jsonl";
  ~ToldLines() override { std::filesystem::remove(file); }
  std::string after(const std::string& text, double time) const {
    EXPECT_TRUE(write_text_atomically(file, text).has_value());
    const Status done = forget_lines_after(file, time);
    EXPECT_TRUE(done.has_value()) << (done ? "" : done.error().message);
    return read_text(file).value();
  }
};

TEST_F(ToldLines, OfLaterThanTheStateAreForgotten) {
  const std::string header = "{\"format\":\"f\"}\n", one = "{\"time_s\":0.1}\n", two = "{\"time_s\":0.2}\n";

  EXPECT_EQ(after(header + one + two, 0.1), header + one);
  EXPECT_EQ(after(header + one + two, 0.1 - 1e-15), header + one);  // the clock is a sum of steps
  EXPECT_EQ(after(header + one + two, 0.05), header);
  EXPECT_EQ(after(header + one + two, 0.3), header + one + two);
}

TEST_F(ToldLines, LoseALastOneThatWasCut) {
  EXPECT_EQ(after("{\"time_s\":0.1}\n{\"time_s\":0.15", 1.0), "{\"time_s\":0.1}\n");
}

TEST_F(ToldLines, GoOnBehindTheState) {
  ASSERT_TRUE(write_text_atomically(file, "{\"time_s\":0.1}\n{\"time_s\":0.2}\n").has_value());

  auto writer = go_on_telling(file, 0.1);

  ASSERT_TRUE(writer.has_value());
  ASSERT_TRUE(writer->append(json::Value::object({{"time_s", 0.25}})).has_value());
  EXPECT_EQ(read_text(file).value(), "{\"time_s\":0.1}\n{\"time_s\":0.25}\n");
  EXPECT_FALSE(go_on_telling("/nowhere/told.jsonl", 0.1).has_value());
}

}  // namespace
}  // namespace granary::dem
