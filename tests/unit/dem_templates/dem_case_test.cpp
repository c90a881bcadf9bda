#include "dem_templates/case/dem_case.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/json/io.hpp"

namespace granary::dem {
namespace {

using testing::HasSubstr;

DemCase an_unusual_case() {
  DemCase c;
  c.name = "wet";
  c.machine.mixer.length = 0.4400000000000001;
  c.machine.mixer.feed_elements = 3;
  c.machine.bowl.chopper_blades = 5;
  c.machine.impeller_speed = 1.0 / 3.0;
  c.machine.shell_stl = "walls/my shell.stl";
  c.machine.refinement = 2;
  c.contact.restitution = 0.1 + 0.2;
  c.density = 476.0;
  c.coarse_graining = 40.0;
  c.population = {{0.0, 0.11, {0.003, 0.004}, {120, 0}}, {0.11, 0.22, {}, {}}};
  c.feed_rate = 15.0 / 3600;
  c.feed_diameter = 0.003;
  c.tally.class_edges = {0.001, 0.0035, 0.005};
  c.guard.lost_fraction = 0.01;
  c.restart = "../0001-dem/restart.liggghts";
  c.seed = 2147483647;
  c.ranks = 2;
  return c;
}

std::string problems_of(json::Value document) {
  const auto c = read_case(document, "case.json");
  return c ? "" : c.error().message;
}

TEST(DemCaseJson, ReadsBackToTheSameBits) {
  for (const bool bowl : {false, true}) {
    DemCase c = an_unusual_case();
    if (bowl) c.machine.type = Machine::Type::batch_bowl, c.feed_rate = 0.0, c.restart.reset();
    const json::Value written = to_json(c);

    const auto document = json::parse(json::dump(written), "case.json");
    ASSERT_TRUE(document);
    const auto again = read_case(*document, "case.json");

    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(json::dump(to_json(*again)), json::dump(written));
    EXPECT_EQ(again->machine.impeller_speed, c.machine.impeller_speed);
    EXPECT_EQ(again->contact.restitution, c.contact.restitution);
    EXPECT_EQ(again->population[0].count, c.population[0].count);
    EXPECT_EQ(again->restart, c.restart);
    EXPECT_EQ(again->seed, c.seed);
  }
}

TEST(DemCaseJson, ReportsEveryProblemAtOnce) {
  json::Value document = to_json(an_unusual_case());
  document.find("contact")->set("restitution", 1.4).set("young_modulus", 1e5);
  document.find("machine")->find("mixer")->set("shaft_length", 0.5);
  document.set("time_step", 0.0).set("densty", 5.0);

  const std::string text = problems_of(document);

  for (const char* said : {"case.json", "/contact/restitution", "1.4", "/contact/young_modulus",
                           "/machine/mixer/shaft_length", "/time_step", "/densty", "density"})
    EXPECT_THAT(text, HasSubstr(said));
}

TEST(DemCaseJson, ZeroParticlesAreAnError) {
  json::Value document = to_json(an_unusual_case());
  document.find("population")->items()[0].set("count", std::vector<double>{0.0, 0.0});
  EXPECT_THAT(problems_of(document), HasSubstr("holds no particles"));

  document.set("population", json::Value::array());
  EXPECT_THAT(problems_of(document), HasSubstr("holds no particles"));
}

TEST(DemCaseJson, CompartmentsMustFollowEachOther) {
  json::Value document = to_json(an_unusual_case());
  document.find("population")->items()[1].set("from", 0.12);
  EXPECT_THAT(problems_of(document), HasSubstr("compartment 2 begins at 0.12 m"));
}

TEST(DemCaseJson, EachDiameterNeedsItsCount) {
  json::Value document = to_json(an_unusual_case());
  document.find("population")->items()[0].set("count", std::vector<double>{120.0});
  EXPECT_THAT(problems_of(document), HasSubstr("/population/0/count"));
}

TEST(DemCaseJson, ClassEdgesMustAscend) {
  json::Value document = to_json(an_unusual_case());
  document.find("tally")->set("class_edges", std::vector<double>{0.002, 0.001});
  EXPECT_THAT(problems_of(document), HasSubstr("must ascend"));
}

TEST(DemCaseJson, ABowlIsNotFed) {
  DemCase c = an_unusual_case();
  c.machine.type = Machine::Type::batch_bowl;
  EXPECT_THAT(problems_of(to_json(c)), HasSubstr("/feed_rate"));
}

}  // namespace
}  // namespace granary::dem
