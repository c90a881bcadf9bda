#include "dem_templates/render/deck.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "dem_templates/geometry/stl.hpp"

namespace granary::dem {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

DemCase a_case() {
  DemCase c;
  c.name = "deck";
  c.population = {{0.0, 0.22, {0.003, 0.004}, {20, 10}}, {0.22, 0.44, {0.004}, {30}}};
  c.tally.class_edges = {0.001, 0.0035, 0.005};
  c.time_step = 1e-5;
  return c;
}

DemCase a_stock_case() {
  DemCase c = a_case();
  c.walls = Walls::stock;
  return c;
}

DemCase a_bowl() {
  DemCase c = a_case();
  c.machine.type = Machine::Type::batch_bowl;
  c.machine.impeller_speed = 31.4;
  c.machine.chopper_speed = 314.0;
  c.population = {{0.0, 0.0641, {0.003}, {300}}};
  return c;
}

std::string script_of(const DemCase& c) {
  const auto all = bodies(c.machine);
  if (!all) return all.error().message;
  const auto script = input_script(c, *all);
  return script ? *script : script.error().message;
}

class Burst : public testing::Test {
 protected:
  Burst() : folder_(fs::temp_directory_path() / ("granary_deck_" + std::to_string(getpid()))) {}
  ~Burst() override { fs::remove_all(folder_); }
  std::string refused(const DemCase& c, const std::string& burst = "0002-dem") {
    const Status written = write_burst(c, folder_ / burst);
    return written ? "" : written.error().message;
  }
  fs::path folder_;
};

TEST(Schedule, WindowsAreWholeLooksAndBurstsWholeWindows) {
  DemCase c = a_case();
  c.settle_time = 0.0123;
  c.duration = 0.0249;
  c.tally.window = 0.00501;
  c.tally.every = 7;

  const Schedule s = schedule_of(c);

  EXPECT_EQ(s.settle, 1230);
  EXPECT_EQ(s.window % 7, 0);
  EXPECT_NEAR(s.window, 501, 4);
  EXPECT_EQ(s.steps % s.window, 0);
  EXPECT_NEAR(s.steps, 2490, s.window / 2);
}

TEST(InputScript, FirstBurstBeginsWithAnEmptyBoxALaterOneWithTheRestart) {
  DemCase c = a_case();
  EXPECT_THAT(script_of(c), AllOf(HasSubstr("create_box"), Not(HasSubstr("read_restart"))));
  c.restart = "../0001-dem/restart.liggghts";
  EXPECT_THAT(script_of(c), AllOf(HasSubstr("read_restart  ../0001-dem/restart.liggghts\n"),
                                  Not(HasSubstr("create_box")), HasSubstr("fix walls all granary/wall"),
                                  HasSubstr("newton        off"), HasSubstr("communicate   single vel yes")));
}

TEST(InputScript, RotationIsAPeriodNotASpeed) {
  DemCase c = a_stock_case();
  c.machine.impeller_speed = 2000.0 / 60 * 2 * 3.14159265358979323846;  // 2000 rpm
  const std::string script = script_of(c);
  const auto at = script.find(" period ");
  ASSERT_NE(at, std::string::npos);
  EXPECT_NEAR(std::stod(script.substr(at + 8)), 0.03, 1e-12);
}

TEST(InputScript, AStandingRotorHasNoMove) {
  DemCase c = a_bowl();
  c.machine.chopper_speed = 0.0;
  EXPECT_THAT(script_of(c),
              AllOf(HasSubstr("mesh chopper meshes/chopper.stl"), HasSubstr("rotate impeller 0 0 0 0 0 1 rad/s 31.4"),
                    Not(HasSubstr("rotate chopper"))));
  c.walls = Walls::stock;
  EXPECT_THAT(script_of(c), AllOf(HasSubstr("fix turn_impeller"), Not(HasSubstr("turn_chopper")),
                                  HasSubstr("n_meshes 3 meshes shell impeller chopper")));
}

TEST(InputScript, StockWallsAreWatchedByOursThatPushNobody) {
  EXPECT_THAT(script_of(a_case()), AllOf(Not(HasSubstr("push no")), HasSubstr("body impeller of walls")));
  const std::string script = script_of(a_stock_case());
  EXPECT_THAT(script,
              AllOf(HasSubstr("fix watch all granary/wall type 2 push no"), HasSubstr("body impeller of watch")));
  // From the step on which the others turn from, too.
  EXPECT_LT(script.find("fix watch"), script.find("\nrun "));
}

TEST(InputScript, RollingFrictionOnlyWhereThereIsSome) {
  DemCase c = a_case();
  EXPECT_THAT(script_of(c), Not(HasSubstr("rolling_friction")));
  c.contact.rolling_friction = 0.1;
  const std::string script = script_of(c);
  EXPECT_THAT(script,
              AllOf(HasSubstr("pair_style    gran model hertz tangential history rolling_friction epsd2"),
                    HasSubstr("granary/wall type 2 rolling_friction epsd2"), HasSubstr("coefficientRollingFriction")));
  c.walls = Walls::stock;
  EXPECT_THAT(script_of(c), HasSubstr("wall/gran model hertz tangential history rolling_friction epsd2 mesh"));
}

TEST(InputScript, FeedsOnlyWhereAsked) {
  DemCase c = a_case();
  EXPECT_THAT(script_of(c), Not(HasSubstr("insert/rate/region")));
  c.feed_rate = 15.0 / 3600;
  EXPECT_THAT(script_of(c), AllOf(HasSubstr("insert/rate/region"), HasSubstr("massrate 0.004166666666666667"),
                                  HasSubstr("radius constant 0.0015")));
}

TEST(InputScript, TheMixerHasAnOutletTheBowlHasNone) {
  EXPECT_THAT(script_of(a_case()), AllOf(HasSubstr("granary/outlet"), HasSubstr("vector 0 -1 0")));
  EXPECT_THAT(script_of(a_bowl()), AllOf(Not(HasSubstr("granary/outlet")), HasSubstr("vector 0 0 -1")));
}

TEST(InputScript, TalliesWhatTheCaseAsksFor) {
  EXPECT_THAT(script_of(a_case()),
              AllOf(HasSubstr("compartments 2 0 0.22 0.44"), HasSubstr("classes 2 0.001 0.0035 0.005"),
                    HasSubstr("window 1000"), HasSubstr("body impeller of walls")));
  EXPECT_THAT(script_of(a_stock_case()), HasSubstr("body impeller of watch"));
}

TEST(InputScript, AgglomeratesTakeThePlaceOfThePopulation) {
  DemCase c = a_bowl();
  c.agglomerates.emplace();
  c.agglomerates->count = 7;
  c.agglomerates->bonds.normal_stiffness = 1e9;
  c.agglomerates->bonds.tensile_strength = 2e5;
  c.agglomerates->bonds.shear_strength_ratio = 0.5;
  c.agglomerates->bonds.strength_scatter = 0.1;

  const std::string script = script_of(c);

  EXPECT_THAT(script, AllOf(HasSubstr("granary/bond normal_stiffness 1000000000 shear_stiffness 458000000 "),
                            HasSubstr("tensile_strength 200000 shear_strength 100000 normal 0.1 "),
                            HasSubstr("pack 37 0.0012 0.005 count 7 "), HasSubstr("region space walls walls"),
                            Not(HasSubstr("all granary/resize"))));
  EXPECT_THAT(script_of(a_bowl()), Not(HasSubstr("granary/bond")));
}

TEST(Schedule, AWindowOfAgglomeratesIsWholeSamplesOrASampleWholeWindows) {
  DemCase c = a_bowl();
  c.agglomerates = Agglomerates{};
  c.time_step = 4.9e-6;
  c.tally = {0.05, 10, c.tally.class_edges};
  const Schedule fine = schedule_of(c);
  c.agglomerates->sample_every = 0.2;
  const Schedule coarse = schedule_of(c);

  EXPECT_EQ(fine.window % 10, 0);
  EXPECT_EQ(fine.window, 5 * fine.sample);
  EXPECT_NEAR(static_cast<double>(fine.sample) * c.time_step, 0.01, 1e-4);
  EXPECT_EQ(coarse.sample, 4 * coarse.window);
}

TEST(InputScript, AgglomeratesLeaveAStateEachWindowAndGoOnFromIt) {
  DemCase c = a_bowl();
  c.agglomerates = Agglomerates{};
  c.settle_time = 0.1;
  c.duration = 1.0;  // windows of a hundredth of a second
  const std::string end = "110000 upto every 1000 \"write_restart restart.part\"";

  EXPECT_THAT(script_of(c), AllOf(HasSubstr(end), HasSubstr("granary/agglomerates"), Not(HasSubstr("goes_on"))));
  c.restart = "restart.liggghts";
  EXPECT_THAT(script_of(c), AllOf(HasSubstr(end), HasSubstr("read_restart  restart.liggghts"), HasSubstr("goes_on yes"),
                                  HasSubstr("granary/bond"), Not(HasSubstr("granary/agglomerates"))));
}

TEST(NeighbourSkin, StaysWithinTheParticlesSize) {
  DemCase c = a_stock_case();
  for (double speed : {0.0, 20.0, 209.0, 2000.0}) {
    c.machine.impeller_speed = speed;
    EXPECT_GE(neighbour_skin(c), 0.25 * 0.004);
    EXPECT_LE(neighbour_skin(c), 2.0 * 0.004);
  }
}

TEST_F(Burst, WritesAllThatTheRunNeeds) {
  for (const DemCase& c : {a_case(), a_bowl()}) {
    const Status written = write_burst(c, folder_ / "0001-dem");
    ASSERT_TRUE(written) << written.error().message;

    const auto document = json::read_file(folder_ / "0001-dem" / "case.json");
    ASSERT_TRUE(document);
    EXPECT_EQ(*document, to_json(c));
    const auto population = json::read_file(folder_ / "0001-dem" / "population.json");
    ASSERT_TRUE(population);
    EXPECT_EQ((*population)["format"].as_string(), "granary-population-1");
    EXPECT_EQ((*population)["compartments"].size(), c.population.size());
    EXPECT_EQ((*population)["compartments"].items()[0]["counts"].items()[0].as_integer(), c.population[0].count[0]);
    EXPECT_TRUE(read_stl(folder_ / "0001-dem" / "meshes" / "shell.stl"));
    EXPECT_TRUE(read_stl(folder_ / "0001-dem" / "meshes" / "impeller.stl"));
    EXPECT_TRUE(fs::exists(folder_ / "0001-dem" / "in.liggghts"));
  }
}

TEST_F(Burst, ZeroParticlesAreRefused) {
  DemCase c = a_case();
  for (Population& p : c.population) p.count.assign(p.count.size(), 0);
  EXPECT_THAT(refused(c), AllOf(HasSubstr("case.json"), HasSubstr("holds no particles")));
}

TEST_F(Burst, AnUnreadableStlIsRefused) {
  DemCase c = a_case();
  fs::create_directories(folder_);
  c.machine.shell_stl = folder_ / "shell.stl";
  EXPECT_THAT(refused(c), AllOf(HasSubstr("shell.stl"), HasSubstr("no such file")));
  std::ofstream(folder_ / "shell.stl") << "PK\x03\x04";
  EXPECT_THAT(refused(c), AllOf(HasSubstr("shell.stl"), HasSubstr("not an STL file")));
}

TEST_F(Burst, ARestartMustExistAndBelongToTheSameMachine) {
  DemCase c = a_case();
  ASSERT_TRUE(write_burst(c, folder_ / "0001-dem"));
  c.restart = "../0001-dem/restart.liggghts";
  EXPECT_THAT(refused(c), AllOf(HasSubstr("restart.liggghts"), HasSubstr("no such restart file")));

  std::ofstream(folder_ / "0001-dem" / "restart.liggghts") << "x";
  EXPECT_EQ(refused(c), "");
  c.machine.impeller_speed *= 2.0;  // another speed is no other machine
  EXPECT_EQ(refused(c), "");

  c.machine.mixer.exit_elements = 5;
  EXPECT_THAT(refused(c), HasSubstr("is the restart of another case"));
}

}  // namespace
}  // namespace granary::dem
