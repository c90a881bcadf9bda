#include "controller/coupling/exchange_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "common/json/io.hpp"
#include "common/results/hdf5_file.hpp"
#include "tests/unit/controller/monitor_lines.hpp"

namespace granary::coupling {
namespace {

namespace fs = std::filesystem;
using test::a_tally_header;
using test::TallyLine;
using ::testing::AllOf;
using ::testing::HasSubstr;

class ExchangeFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("granary_exchange_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) +
               "_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Two compartments, a grid of 2 x 3, outputs at 0, 0.2 and 0.4 s; number[t][x][i][j] = 1000 t + 100 x + 10 i + j.
  void write_out_h5(const fs::path& file) {
    auto h5 = Hdf5File::create(file);
    ASSERT_TRUE(h5);
    ASSERT_TRUE(h5->attribute("/", "format", "granary-pbm-out-1"));
    ASSERT_TRUE(h5->write("/grid/solid_1", {{2}, {1e-15, 3e-15}}, "m^3", ""));
    ASSERT_TRUE(h5->write("/grid/solid_2", {{3}, {1e-15, 3e-15, 9e-15}}, "m^3", ""));
    ASSERT_TRUE(h5->create_growing("/state/time", {}, "s", ""));
    for (const char* name : {"/state/number", "/state/liquid", "/state/gas"})
      ASSERT_TRUE(h5->create_growing(name, {2, 2, 3}, "", ""));
    for (int t = 0; t < 3; ++t) {
      std::vector<double> number, liquid(12, 1e-16 * t), gas(12, 2e-16 * t);
      for (int x = 0; x < 2; ++x)
        for (int i = 0; i < 2; ++i)
          for (int j = 0; j < 3; ++j) number.push_back(1000 * t + 100 * x + 10 * i + j);
      ASSERT_TRUE(h5->append_row("/state/time", {0.2 * t}));
      ASSERT_TRUE(h5->append_row("/state/number", number));
      ASSERT_TRUE(h5->append_row("/state/liquid", liquid));
      ASSERT_TRUE(h5->append_row("/state/gas", gas));
    }
  }

  fs::path write_tallies(int n) {
    auto writer = json::LineWriter::create(folder_ / "tallies.jsonl");
    EXPECT_TRUE(writer && writer->append(a_tally_header()));
    for (int w = 0; w < n; ++w) {
      TallyLine line;
      line.time = 0.01 * (w + 1);
      EXPECT_TRUE(writer->append(line.json()));
    }
    return folder_ / "tallies.jsonl";
  }

  fs::path folder_;
};

TEST_F(ExchangeFiles, ReadsTheStateAtTheTimeTheMonitorNamed) {
  write_out_h5(folder_ / "out.h5");
  const auto hold_up = read_hold_up(folder_ / "out.h5", 0.2);

  ASSERT_TRUE(hold_up) << hold_up.error().message;
  EXPECT_EQ(0.2, hold_up->time);
  EXPECT_EQ(2u, hold_up->n_compartments());
  EXPECT_EQ(1112.0, hold_up->number[1][1][2]);
  EXPECT_EQ(1e-16, hold_up->liquid[0][0][0]);
  EXPECT_EQ(2e-16, hold_up->gas[1][1][2]);
  EXPECT_EQ(9e-15, hold_up->solid_2[2]);
}

TEST_F(ExchangeFiles, ReadsTheLastStateWhereNoTimeIsNamed) {
  write_out_h5(folder_ / "out.h5");
  EXPECT_EQ(0.4, read_hold_up(folder_ / "out.h5", std::nullopt)->time);
}

TEST_F(ExchangeFiles, NamesTheNearestStateWhereThereIsNone) {
  write_out_h5(folder_ / "out.h5");
  const auto none = read_hold_up(folder_ / "out.h5", 0.25);

  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message,
              AllOf(HasSubstr("out.h5: has no state at 0.25 s"), HasSubstr("nearest is at 0.2 s")));
}

TEST_F(ExchangeFiles, SaysWhatToDoAboutAMissingOrForeignFile) {
  EXPECT_THAT(read_hold_up(folder_ / "out.h5", 0.2).error().message,
              AllOf(HasSubstr("out.h5"), HasSubstr("See pbm.out")));
  {
    auto h5 = Hdf5File::create(folder_ / "other.h5");
    ASSERT_TRUE(h5 && h5->attribute("/", "format", "something-else"));
  }
  EXPECT_THAT(read_hold_up(folder_ / "other.h5", 0.2).error().message, HasSubstr("format is \"something-else\""));
}

TEST_F(ExchangeFiles, MeasuresABurstFromItsFolder) {
  write_tallies(30);
  RateSettings settings;
  settings.grace = 0.1;
  const auto measured = measure_burst(folder_, {1e-4}, settings);

  ASSERT_TRUE(measured) << measured.error().message;
  EXPECT_EQ(20u, measured->windows);
  EXPECT_EQ(20.0, measured->coarse_graining);
  EXPECT_EQ(20.0 * 1000.0, measured->summary.collisions);
  EXPECT_NEAR(2.0 * 1000.0 / (1010.0 * 0.01), measured->summary.collision_frequency, 1e-9);
  // Class 1 with itself: 990 a window among 1000 particles, carried to real sizes by 20^-3.
  EXPECT_NEAR(990.0 / (0.5 * 1000.0 * 999.0 * 0.01 / 1e-4) / 8000.0, measured->rates.collision_rate[0][0],
              3.0 * measured->standard_error[0][0]);
}

TEST_F(ExchangeFiles, NameFileAndLineOfATallyThatWasCut) {
  const fs::path file = write_tallies(3);
  EXPECT_THAT(read_tallies(folder_ / "nothing.jsonl").error().message, HasSubstr("nothing.jsonl"));
  std::ofstream(file, std::ios::app) << R"({"time_s": 0.04, "par)";
  EXPECT_THAT(read_tallies(file).error().message, AllOf(HasSubstr("tallies.jsonl"), HasSubstr("number 5")));
  std::ofstream(file, std::ios::app) << "ticles\": 7}\n";
  EXPECT_THAT(read_tallies(file).error().message,
              AllOf(HasSubstr("tallies.jsonl, line 5: /particles"), HasSubstr("run the burst again")));
  std::ofstream(file, std::ios::trunc) << "";
  EXPECT_THAT(read_tallies(file).error().message, HasSubstr("is empty"));
}

TEST_F(ExchangeFiles, TellsTheSpeedThatOneContactInAThousandExceeds) {
  const auto fastest = [&](const std::string& collisions, const std::string& impacts) {
    std::ofstream(folder_ / "tallies.jsonl") << R"({"speed_edges_m_s": [0.1, 1, 10, 20, 40]})"
                                             << "\n{\"collision_speed\": {\"histogram\": [" << collisions
                                             << "]}, \"impact_speed\": {\"histogram\": [" << impacts << "]}}\n";
    return fastest_contacts(folder_ / "tallies.jsonl").value();
  };

  EXPECT_EQ(fastest("1000, 0, 0, 0", "990, 8, 2, 0"), 10.0);
  EXPECT_EQ(fastest("1000, 0, 0, 0", "980, 8, 10, 2"), 20.0);
  EXPECT_EQ(fastest("1000, 0, 0, 5", "1000, 0, 0, 0"), 40.0);
  EXPECT_EQ(fastest("100, 0, 0, 5", "100, 0, 0, 0"), 0.0) << "too few to tell";
  EXPECT_THAT(fastest_contacts(folder_ / "nothing.jsonl").error().message, HasSubstr("nothing.jsonl"));
}

}  // namespace
}  // namespace granary::coupling
