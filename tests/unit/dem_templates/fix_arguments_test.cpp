// The keywords of our fix commands: read, or refused with all that is wrong.
#include "dem_templates/plugin/input/fix_arguments.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace granary::dem {
namespace {

using Range = FixArguments::Range;

FixArguments read(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return FixArguments(
      words, {{"file"}, {"every"}, {"axis"}, {"classes", FixArguments::kEdges}, {"body", 3, true}, {"speed_bins", 3}});
}

TEST(FixArguments, ReadsKeywordsInAnyOrder) {
  auto arguments =
      read("t all granary/tally classes 2 0.1 0.2 0.3 body a mesh m every 7 body b wall w file x.jsonl axis z");
  EXPECT_EQ(arguments.edges("classes"), (std::vector<double>{0.1, 0.2, 0.3}));
  EXPECT_EQ(arguments.integer("every", Range::at_least(1)), 7);
  EXPECT_EQ(arguments.text("file"), "x.jsonl");
  EXPECT_EQ(arguments.axis("axis"), 2);
  ASSERT_EQ(arguments.all("body").size(), 2u);
  EXPECT_EQ(arguments.all("body")[1][0], "b");
  EXPECT_TRUE(arguments.status());
}

std::string fault(const std::string& line) {
  auto arguments = read(line);
  arguments.text("file");
  arguments.edges("classes");
  arguments.axis("axis");
  arguments.integer_or("every", 5, Range::at_least(1));
  const Status status = arguments.status();
  return status ? "" : status.error().message;
}

TEST(FixArguments, SaysWhatIsMissingWrongOrUnknown) {
  const std::string place = "fix t (granary/tally): ", docs = " See docs/dem_styles.md.";
  EXPECT_EQ(fault("t all granary/tally file f classes 1 1 2 axis x"), "");
  EXPECT_EQ(fault("t all granary/tally classes 1 1 2 axis x"), place + "needs the keyword 'file'." + docs);
  EXPECT_EQ(fault("t all granary/tally fiel f"), place + "'fiel' is no keyword of it; did you mean 'file'?" + docs);
  EXPECT_EQ(fault("t all granary/tally file f classes 1 2 1 axis x"),
            place + "the edges of 'classes' must ascend: edge 1 does not." + docs);
  EXPECT_EQ(fault("t all granary/tally file f axis x classes 3 1 2"),
            place + "'classes' needs 4 value(s), 2 are given." + docs);
  EXPECT_EQ(fault("t all granary/tally file f axis x classes many"),
            place + "'classes' needs its length, a whole number of at least 1." + docs);
  EXPECT_EQ(fault("t all granary/tally file f classes 1 1 2 axis w every 0"),
            place + "'axis' is 'w'; it must be x, y or z." + docs + "\n" + place +
                "'every' is '0'; it must be a whole number >= 1." + docs);
  EXPECT_EQ(fault("t all granary/tally file f file g classes 1 1 2 axis x"), place + "'file' is given twice." + docs);
}

}  // namespace
}  // namespace granary::dem
