#include "pbm_solver/case/pbm_case.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/json/io.hpp"
#include "tests/support/pbm_cases.hpp"

namespace granary::pbm {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Result<PbmCase> read_text_case(const std::string& text) {
  const auto document = json::parse(text, "case.json");
  if (!document) return document.error();
  return read_case(*document, "case.json");
}

std::string message_of(const std::string& text) {
  const auto read = read_text_case(text);
  return read ? "" : read.error().message;
}

PbmCase a_full_case() {
  PbmCase c = testing::a_granulator(16, 3);
  c.dem->compartment_factor = {1.0, 0.7, 0.1 + 0.2};
  c.initial = {{-1, 2, 3, 1e7, 1e-12, 2e-12}, {1, 0, 15, 3.0, 0.0, 0.0}};
  c.aggregation->efficiency.model = Efficiency::Model::wet;
  c.breakage->daughters = Breakage::Daughters::same_composition;
  return c;
}

TEST(PbmCase, ComesBackFromItsJsonUnchanged) {
  const PbmCase c = a_full_case();

  const json::Value written = to_json(c);
  const auto read = read_text_case(json::dump(written));

  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(json::dump(to_json(*read)), json::dump(written));
  EXPECT_EQ(read->dem->compartment_factor, c.dem->compartment_factor);
  EXPECT_EQ(read->initial.size(), 2u);
  EXPECT_EQ(read->breakage->daughters, Breakage::Daughters::same_composition);
}

TEST(PbmCase, ComesBackWithABreakageTable) {
  PbmCase c = testing::a_granulator();
  c.breakage->selection = Breakage::Selection::table;
  c.breakage->daughters = Breakage::Daughters::table;
  c.breakage->table = {{1e-15, 1e-12}, {0.0, 0.1 + 0.2}, {{}, {{0.75, 1.0}, {0.0625, 4.0}}}};

  const json::Value written = to_json(c);
  const auto read = read_text_case(json::dump(written));

  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(json::dump(to_json(*read)), json::dump(written));
  EXPECT_EQ(read->breakage->table.daughters[1][1].number, 4.0);
}

TEST(PbmCase, RefusesABreakageTableThatMakesOrLosesVolume) {
  PbmCase c = testing::a_granulator();
  c.breakage->daughters = Breakage::Daughters::table;
  c.breakage->table = {{1e-12, 1e-15}, {1.0}, {{{0.5, 2.1}}, {{1.0, 1.0}}}};

  const std::string message = message_of(json::dump(to_json(c)));

  EXPECT_THAT(message, HasSubstr("/breakage/table/solid"));
  EXPECT_THAT(message, HasSubstr("/breakage/table/rate"));
  EXPECT_THAT(message, HasSubstr("add up to 1.05"));
}

TEST(PbmCase, ComesBackWithARestart) {
  PbmCase c = testing::a_granulator();
  c.restart = Restart{"bursts/0001-pbm/out.h5", 1.4};

  const auto read = read_text_case(json::dump(to_json(c)));

  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->restart->file, "bursts/0001-pbm/out.h5");
  EXPECT_EQ(read->restart->time, 1.4);
}

RC_GTEST_PROP(PbmCase, KeepsEveryBitOfItsNumbers, ()) {
  const auto any_positive = [] {
    const double mantissa = 1.0 + *rc::gen::inRange<int>(0, 1 << 30) / double(1 << 30);
    return std::ldexp(mantissa, *rc::gen::inRange<int>(-60, 60));
  };
  PbmCase c = testing::a_granulator(4, 2);
  c.compartments.volume = {any_positive(), any_positive()};
  c.materials.liquid_viscosity = any_positive();
  c.aggregation->rate = any_positive();
  c.breakage->primary_diameter = any_positive();
  c.reference_volume = any_positive();
  c.feed->classes[0].rate = any_positive();

  const auto read = read_text_case(json::dump(to_json(c)));

  RC_ASSERT(read.has_value());
  RC_ASSERT(read->compartments.volume == c.compartments.volume);
  RC_ASSERT(read->materials.liquid_viscosity == c.materials.liquid_viscosity);
  RC_ASSERT(read->aggregation->rate == c.aggregation->rate);
  RC_ASSERT(read->breakage->primary_diameter == c.breakage->primary_diameter);
  RC_ASSERT(read->reference_volume == c.reference_volume);
  RC_ASSERT(read->feed->classes[0].rate == c.feed->classes[0].rate);
}

TEST(PbmCase, ReportsEveryProblemAtOnceWithItsPlace) {
  const std::string message = message_of(R"({
    "format": "granary-pbm-case-1",
    "grid": {"bins": [8, 8], "ratio": [3, 1]},
    "compartments": {"count": 2, "volume": [1.0]},
    "feed": {"classes": [{"i": 8, "j": 0, "rate": 1}, {"i": 0, "j": 0, "rate": -1}]},
    "spray": {"rate": 1e-6, "compartment": 2},
    "aggregation": {"kernel": "dem"},
    "breakage": {"selection": "impact"},
    "initial": [{"compartment": 5, "i": 0, "j": -1, "number": 3}],
    "end_time": -1})");

  for (const char* place :
       {"/grid/ratio/1", "/compartments/volume", "/feed/classes/0/i", "/feed/classes/1/rate", "/spray/compartment",
        "/aggregation/kernel", "/breakage/selection", "/initial/0/compartment", "/initial/0/j", "/end_time"})
    EXPECT_THAT(message, HasSubstr(std::string("case.json: ") + place + " ")) << message;
}

TEST(PbmCase, RefusesClassesThatCannotBeToldApart) {
  const std::string message = message_of(R"({"format": "granary-pbm-case-1", "end_time": 1,
    "grid": {"bins": [2, 2], "smallest": [5e-324, 1], "ratio": [2, 1.0000001]}})");

  EXPECT_THAT(message, HasSubstr("case.json: /grid/smallest is [5e-324,1"));
  EXPECT_THAT(message, HasSubstr("case.json: /grid/ratio is [2,1.0000001]"));
}

TEST(PbmCase, SuggestsTheKeyThatWasMeant) {
  const std::string message = message_of(R"({"format": "granary-pbm-case-1", "grid": {"bin": [8, 8]}, "end_time": 1})");

  EXPECT_THAT(message, HasSubstr("/grid/bin"));
  EXPECT_THAT(message, HasSubstr("\"bins\""));
}

TEST(PbmCase, SuggestsTheKernelThatWasMeant) {
  const std::string message =
      message_of(R"({"format": "granary-pbm-case-1", "grid": {}, "aggregation": {"kernel": "prodct"}, "end_time": 1})");

  EXPECT_THAT(message, HasSubstr("/aggregation/kernel is \"prodct\""));
  EXPECT_THAT(message, HasSubstr("product"));
}

TEST(PbmCase, RefusesCollisionRatesThatAreNotSymmetric) {
  PbmCase c = testing::a_granulator(4, 1);
  c.dem->collision_rate[1][0] *= 1.5;

  const auto read = read_case(to_json(c), "case.json");

  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, HasSubstr("/dem/collision_rate"));
  EXPECT_THAT(read.error().message, HasSubstr("symmetric"));
  EXPECT_EQ(read.error().exit, Exit::bad_input);
}

TEST(PbmCase, RefusesRatesThatDoNotFitTheClasses) {
  PbmCase c = testing::a_granulator(4, 2);
  c.dem->impact_rate.pop_back();
  c.dem->collision_rate.pop_back();
  c.dem->compartment_factor = {1.0};

  const auto read = read_case(to_json(c), "case.json");

  ASSERT_FALSE(read);
  for (const char* place : {"/dem/impact_rate", "/dem/collision_rate", "/dem/compartment_factor"})
    EXPECT_THAT(read.error().message, HasSubstr(place));
}

TEST(PbmCase, HasNoUnknownKeysInWhatItWrites) {
  const auto read = read_case(to_json(testing::a_granulator()), "case.json");

  ASSERT_TRUE(read) << read.error().message;
  EXPECT_THAT(json::dump(to_json(*read)), Not(HasSubstr("residence_time\":null")));
}

}  // namespace
}  // namespace granary::pbm
