// The bench's document as tables and as a plot. Measuring is granary-pbm's part.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/json/io.hpp"
#include "controller/bench/pbm_plot.hpp"
#include "controller/bench/pbm_table.hpp"

namespace granary::bench {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

json::Value a_document() {
  return *json::parse(R"({
    "rhs": [{"grid": "16x16x16", "classes": 8, "kernel": "dem classes", "cores": 1, "solver_s": 7.5e-5,
             "reference_s": 7.5e-3, "ratio": 100.0, "reference_how": "median of all compartments, 11 rounds"},
            {"grid": "16x16x16", "classes": 8, "kernel": "dem classes x stokes", "cores": 1, "solver_s": 1.9e-4,
             "reference_s": null, "ratio": null, "kernel_refresh_s": 2e-3}],
    "work_precision": [
      {"method": "solver", "bins": 16, "tolerance": 0.1, "rhs_evaluations": 44, "cpu_s": 1.2e-3, "l1_number": 0.124},
      {"method": "solver", "bins": 32, "tolerance": 0.1, "rhs_evaluations": 44, "cpu_s": 7e-3, "l1_number": 0.034},
      {"method": "reference", "bins": 16, "tolerance": 0.1, "rhs_evaluations": 48, "cpu_s": 0.02, "l1_number": 0.116}],
    "work_precision_left_out": [{"method": "reference", "bins": 64, "tolerance": 0.1, "why": "no time for it"}],
    "speedup_at_error": [
      {"error": 0.12, "ratio": 16.4, "solver_s": 1.2e-3, "reference_s": 0.02, "is_lower_bound": false, "how": "so"},
      {"error": 0.013, "ratio": 444.4, "solver_s": 5e-2, "reference_s": 23.6, "is_lower_bound": true, "how": "so"}],
    "threads_efficiency": null, "threads_efficiency_why": "there is one core only"})",
                      "document");
}

TEST(PbmTable, MarksWhatIsOnlyALowerBound) {
  const std::string table = pbm_table(a_document());

  EXPECT_THAT(table, HasSubstr(">=     444x"));
  EXPECT_THAT(table, Not(HasSubstr(">=      16x")));
}

TEST(PbmTable, NamesEveryRunThatWasLeftOutAndWhy) {
  EXPECT_THAT(pbm_table(a_document()), HasSubstr("reference     64        0.1 left out: no time for it"));
  EXPECT_THAT(pbm_table(a_document()), HasSubstr("2 threads: not measured: there is one core only"));
}

TEST(PbmTable, ShowsTimesWithUnits) {
  EXPECT_EQ(duration_text(json::Value(7.5e-5)), "75 us");
  EXPECT_EQ(duration_text(json::Value(0.0123)), "12.3 ms");
  EXPECT_EQ(duration_text(json::Value(23.59)), "23.6 s");
  EXPECT_EQ(duration_text(json::Value()), "-");
  EXPECT_THAT(pbm_table(a_document()), HasSubstr("the kernel anew: 2 ms"));
}

TEST(PbmPlot, HasACurveForEachMethodAndGrid) {
  const std::string script = work_precision_script(a_document());

  EXPECT_THAT(script, HasSubstr("$solver_16 << EOD\n0.0012 12.4\nEOD\n"));
  EXPECT_THAT(script, HasSubstr("$solver_32 with linespoints"));
  EXPECT_THAT(script, HasSubstr("$reference_16 with linespoints"));
  EXPECT_THAT(script, Not(HasSubstr("reference_64"))) << "it was left out";
}

}  // namespace
}  // namespace granary::bench
