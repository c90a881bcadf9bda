#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "common/json/reader.hpp"
#include "common/json/schema.hpp"

namespace granary::json {
namespace {
namespace fs = std::filesystem;

Value parsed(std::string_view text) { return parse(text, "test.json").value(); }

fs::path scratch(const std::string& name) {
  const fs::path folder = fs::temp_directory_path() / ("granary_json_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  return folder / name;
}

TEST(Json, PrintsNumbersThatReadBackToTheSameBits) {
  for (const double x : {0.1, 1.0 / 3.0, 5e-16, 6.02214076e23, -0.0, 4.9e-324}) {
    const Value back = parsed(dump(Value(std::vector<double>{x})));
    EXPECT_EQ(std::signbit(x), std::signbit(back.numbers()[0]));
    EXPECT_EQ(x, back.numbers()[0]);
  }
}

TEST(Json, WritesNotANumberAsNull) { EXPECT_EQ("[null]", dump(Value(std::vector<double>{std::nan("")}))); }

TEST(Json, KeepsTheOrderOfMembers) { EXPECT_EQ(R"({"z":1,"a":2})", dump(parsed(R"({"z": 1, "a": 2})"))); }

TEST(Json, NamesLineAndColumnOfASyntaxError) {
  const auto result = parse("{\n  \"a\": 1,\n  oops\n}", "wet.json");
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, testing::StartsWith("wet.json: not valid JSON at line 3, column 3"));
}

TEST(Json, RefusesBracketsThatNestTooDeep) {
  const auto nested = [](std::size_t depth) {
    return parse(std::string(depth, '[') + "\"]]\\\"[[\"" + std::string(depth, ']'), "deep.json");
  };
  EXPECT_TRUE(nested(200));
  ASSERT_FALSE(nested(201));
  EXPECT_EQ(nested(1000000).error().message,
            "deep.json: its brackets nest too deep at line 1, column 201. A bracket may be missing.");
}

TEST(Json, RefusesAKeyWrittenTwice) {
  const auto result = parse(R"({"a": 1, "b": {"a": 2}, "a": 3})", "wet.json");
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, testing::HasSubstr("\"a\" stands twice"));
}

TEST(LineReader, GivesWholeLinesOnlyAndFollowsTheFile) {
  const fs::path file = scratch("lines.jsonl");
  LineReader reader(file);
  EXPECT_TRUE(reader.next().value().empty());
  std::ofstream(file) << "{\"a\":1}\n{\"a\":";

  EXPECT_EQ(1u, reader.next().value().size());
  EXPECT_EQ(5u, reader.torn_bytes());
  std::ofstream(file, std::ios::app) << "2}\n";

  const auto rest = reader.next().value();
  ASSERT_EQ(1u, rest.size());
  EXPECT_EQ(2, rest[0]["a"].as_integer());
}

TEST(LineReader, SaysWhichLineIsBroken) {
  const fs::path file = scratch("broken.jsonl");
  std::ofstream(file) << "{}\n{]\n";
  const auto result = LineReader(file).next();
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, testing::HasSubstr("broken.jsonl, line 2: not valid JSON"));
}

TEST(ReadLines, RefusesATornLastLine) {
  const fs::path file = scratch("torn.jsonl");
  std::ofstream(file) << "{}\n{\"a\":";
  const auto result = read_lines(file);
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, testing::HasSubstr("last line, number 2, is cut short"));
}

TEST(LineWriter, SaysThatTheDiskIsFull) {
  auto writer = LineWriter::append_to("/dev/full").value();
  const auto result = writer.append(Value::object({{"a", 1}}));
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message,
              testing::HasSubstr("/dev/full: cannot be written: No space left on device. Free some space"));
}

TEST(Reader, ReportsEveryProblemAtOnce) {
  const Value document =
      parsed(R"({"time_step": "5 kg", "frction": 0.5, "count": 1.5, "kind": "tow-way", "share": 2})");
  Problems problems;
  Reader reader(document, "wet.json", problems);

  reader.quantity("time_step", "s", Range::positive());
  reader.number_or("friction", 0.5, Range::fraction());
  reader.integer("count");
  reader.choice("kind", {"two-way", "one-way"});
  reader.number("share", Range::fraction());
  reader.text("name");
  reader.done();

  EXPECT_EQ(
      "wet.json: /count is 1.5: it must be a whole number.\n"
      "wet.json: /frction: no such setting. Did you mean \"friction\"?\n"
      "wet.json: /kind is \"tow-way\": it must be one of: two-way, one-way. Did you mean \"two-way\"?\n"
      "wet.json: /name: it is missing and must be given.\n"
      "wet.json: /share is 2: it must be in [0, 1].\n"
      "wet.json: /time_step is \"5 kg\": kg is not of the kind wanted; use a unit such as s.",
      problems.error().message);
}

TEST(Reader, ConvertsQuantitiesToSi) {
  const Value document = parsed(R"({"speed": "2000 rpm", "feed": "15 kg/h", "size": "2 mm"})");
  Problems problems;
  Reader reader(document, "wet.json", problems);
  EXPECT_NEAR(209.43951, reader.quantity("speed", "rad/s"), 1e-5);
  EXPECT_NEAR(15.0 / 3600.0, reader.quantity("feed", "kg/s"), 1e-12);
  EXPECT_NEAR(2e-3, reader.quantity("size", "m"), 1e-15);
  EXPECT_TRUE(problems.empty());
}

TEST(Reader, RefusesABareNumberWhereAQuantityIsWanted) {
  const Value document = parsed(R"({"size": 2, "speed": "2000"})");
  Problems problems;
  Reader reader(document, "wet.json", problems);
  reader.quantity("size", "m");
  reader.quantity("speed", "rad/s");
  EXPECT_EQ(
      "wet.json: /size is 2: it must be a number with a unit in quotes, such as \"1 m\".\n"
      "wet.json: /speed is \"2000\": it has no unit; write for example \"2000 rad/s\".",
      problems.error().message);
}

TEST(Schema, PointsAtTheValueItRefuses) {
  const Value schema = parsed(
      R"({"type": "object", "properties": {"dem": {"type": "object", "properties": {"n": {"type": "integer"}}}}})");
  Problems problems;
  ASSERT_TRUE(validate(parsed(R"({"dem": {"n": "many"}})"), schema, "wet.json", problems));
  const bool found = std::any_of(problems.list().begin(), problems.list().end(), [](const Problem& problem) {
    return problem.pointer == "/dem/n" && problem.value == "\"many\"";
  });
  EXPECT_TRUE(found) << problems.error().message;
}

TEST(DidYouMean, FindsSwappedLettersAndGivesUpOnOthers) {
  EXPECT_EQ("friction", did_you_mean("frcition", {"restitution", "friction"}));
  EXPECT_EQ("", did_you_mean("colour", {"restitution", "friction"}));
}

TEST(Files, WriteNothingWhenTheyCannotWriteAll) {
  const auto result = write_text_atomically("/proc/granary", "x");
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, testing::StartsWith("/proc/granary: cannot be written"));
}

}  // namespace
}  // namespace granary::json
