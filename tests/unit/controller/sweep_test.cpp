// Sweeps: cases from a workflow, figures from what the cases left, and the files they are told in.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "common/json/io.hpp"
#include "common/results/hdf5_file.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/sweep/kernel.hpp"
#include "controller/sweep/outcome.hpp"
#include "controller/sweep/page.hpp"

namespace granary::sweep {
namespace {

namespace fs = std::filesystem;
using campaign::Campaign;
using testing::ElementsAre;
using testing::HasSubstr;

const fs::path kComplete = fs::path(GRANARY_SOURCE_DIR) / "tests/data/workflows_complete";

Campaign read(const std::string& name, const std::vector<std::string>& overrides = {}) {
  auto campaign = campaign::read_campaign(kComplete / name, overrides);
  EXPECT_TRUE(campaign.has_value()) << (campaign ? "" : campaign.error().message);
  return campaign.value_or(Campaign{});
}

std::string problems(const std::vector<std::string>& overrides) {
  const auto campaign = campaign::read_campaign(kComplete / "sweep_pbm.json", overrides);
  return campaign ? "" : campaign.error().message;
}

json::Value line(const std::string& text) { return json::parse(text, "line").value(); }

TEST(Sweep, IsEveryCombinationTheLastFastestAndThenTheList) {
  const Campaign sweep = read("sweep_pbm.json");

  const auto& cases = sweep.sweep.cases;
  ASSERT_EQ(cases.size(), 6u);
  std::vector<double> rates;
  std::vector<int> bins;
  for (const auto& one : cases) {
    rates.push_back(one.understood->pbm_case.breakage->rate);
    bins.push_back(one.understood->pbm_case.grid.bins[1]);
  }
  EXPECT_THAT(rates, ElementsAre(1.0, 1.0, 2.0, 2.0, 1.0, 0.1));
  EXPECT_THAT(bins, ElementsAre(16, 20, 16, 20, 16, 16));
  EXPECT_EQ(cases[4].understood->pbm_case.relative_tolerance, 1e-4);
  EXPECT_EQ(cases[5].name, "0006");
  EXPECT_EQ(cases[0].understood->pbm_case.end_time, 10.0);
  std::vector<std::string> names;
  for (const auto& setting : sweep.sweep.settings) names.push_back(setting.name);
  EXPECT_THAT(names, ElementsAre("k", "bins", "tolerance", "breakage", "rate"));
}

TEST(Sweep, TakesOverridesForAllOfItsCases) {
  const Campaign sweep = read("sweep_pbm.json", {"/process/duration=3 s", "/sweep/grid/0/values=[4]"});

  EXPECT_EQ(sweep.sweep.cases.size(), 4u);
  for (const auto& one : sweep.sweep.cases) EXPECT_EQ(one.understood->pbm_case.end_time, 3.0);
}

TEST(Sweep, OfADemHoldsAgglomeratesAndAStepThatTheirBondsBear) {
  const Campaign sweep = read("sweep_dem.json");

  ASSERT_EQ(sweep.sweep.cases.size(), 2u);
  const dem::DemCase& one = sweep.sweep.cases[0].understood->dem_case;
  EXPECT_EQ(one.agglomerates->count, 10);
  EXPECT_DOUBLE_EQ(one.agglomerates->bonds.tensile_strength, 5e4);
  EXPECT_EQ(one.population.front().count.front(), 130);
  EXPECT_DOUBLE_EQ(one.duration, 0.1);
  EXPECT_GT(one.time_step, 1e-7);
  const Campaign stiff = read("sweep_dem.json", {"/agglomerates/bonds/normal_stiffness=1e11 N/m^3"});
  EXPECT_LT(stiff.sweep.cases[0].understood->dem_case.time_step, 0.3 * one.time_step);
}

TEST(Sweep, SaysEverythingThatIsWrongAtOnce) {
  const std::string said = problems({"/sweep/grid/0/values=[1, -1]", "/sweep/grid/1/setting=/pbm/bin",
                                     "/sweep/cases/0={\"/resources/cores\": 2}", "/process/duration=1"});

  EXPECT_THAT(said, HasSubstr("/sweep/grid/0/values/1 is -1: it must be"));
  EXPECT_THAT(said, HasSubstr("/sweep/grid/1/setting is \"/pbm/bin\": no such setting. Did you mean /pbm/bins?"));
  EXPECT_THAT(said, HasSubstr("belongs to the sweep as a whole"));
  EXPECT_THAT(said, HasSubstr("/process/duration is 1"));
  EXPECT_THAT(problems({"/sweep/grid=[]", "/sweep/cases=[]"}), HasSubstr("/sweep/cases"));
  EXPECT_THAT(problems({"/dem/particles=5"}), HasSubstr("/dem"));
}

TEST(SweepOutcome, HasACurveOfEveryNumberOverTime) {
  const auto curves =
      curves_of({line(R"({"format": "header", "compartments": 2})"),
                 line(R"({"time_s": 0.5, "step": 3, "d50_m": [1.0], "number": [2, 3], "outlet": {"d50_m": null}})"),
                 line(R"({"time_s": 1.0, "step": 9, "d50_m": [4.0], "number": [5, 6], "outlet": {"d50_m": 7.0}})")});

  std::vector<std::string> names;
  for (const Curve& curve : curves) names.push_back(curve.name);
  EXPECT_THAT(names, ElementsAre("d50_m", "number[1]", "number[2]", "outlet.d50_m"));
  EXPECT_THAT(curves[0].time, ElementsAre(0.5, 1.0));
  EXPECT_THAT(curves[2].value, ElementsAre(3.0, 6.0));
  EXPECT_TRUE(std::isnan(curves[3].value[0]));
}

TEST(SweepOutcome, CountsBreaksUpToEachSampleByTheirCause) {
  const auto curves =
      breaks_by_cause({line(R"({"time_s": 0.1, "cause": "shell"})"), line(R"({"time_s": 0.2, "cause": "chopper"})"),
                       line(R"({"time_s": 0.25, "cause": "shell"})")},
                      {0.0, 0.1, 0.2, 0.3});

  ASSERT_EQ(curves.size(), 2u);
  EXPECT_EQ(curves[0].name, "broken_by_chopper");
  EXPECT_THAT(curves[0].value, ElementsAre(0.0, 0.0, 1.0, 1.0));
  EXPECT_THAT(curves[1].value, ElementsAre(0.0, 1.0, 1.0, 2.0));
}

SweepResults two_cases() {
  SweepResults results;
  results.name = "study";
  results.solver = "dem";
  results.settings = {"impeller", "note, with a comma"};
  results.cases = {
      {"0001", {"50 rpm", "a \"b\""}, "finished", 2.0, 1.5, {{"d50_m", 0.5}}, {{"d50_m", {0.0, 1.0}, {1.0, 0.5}}}},
      {"0002", {"100 rpm", ""}, "failed", 1.0, 0.5, {{"number", 3.0}}, {}}};
  return results;
}

TEST(SweepResults, AreATableThatReadsBack) {
  EXPECT_EQ(to_csv(two_cases()),
            "case,impeller,\"note, with a comma\",state,wall_s,cpu_s,d50_m,number\n"
            "0001,50 rpm,\"a \"\"b\"\"\",finished,2,1.5,0.5,\n"
            "0002,100 rpm,,failed,1,0.5,,3\n");
  EXPECT_EQ(to_json(two_cases())["cases"].items()[0]["figures"].number_or("d50_m", 0.0), 0.5);
}

TEST(SweepResults, StandInHdf5WithTheirUnits) {
  const fs::path file = fs::path(testing::TempDir()) / ("sweep_" + std::to_string(getpid()) + ".h5");
  ASSERT_TRUE(write_h5(two_cases(), file).has_value());

  const auto h5 = Hdf5File::open(file);
  ASSERT_TRUE(h5.has_value());
  EXPECT_THAT(h5->read("/curve/0001/d50_m/value")->values, ElementsAre(1.0, 0.5));
  EXPECT_EQ(h5->text_attribute("/sweep/figure/d50_m", "unit").value(), "m");
  EXPECT_THAT(h5->read_texts("/sweep/setting/0001").value(), ElementsAre("50 rpm", "100 rpm"));
  EXPECT_TRUE(std::isnan(h5->read("/sweep/figure/d50_m")->values[1]));
  fs::remove(file);
}

struct CountingPlotter : report::Plotter {
  std::vector<report::Plot> drawn;
  Result<std::vector<std::string>> draw(const std::vector<report::Plot>& plots) override {
    drawn = plots;
    return std::vector<std::string>(plots.size(), "<svg></svg>");
  }
};

TEST(SweepPage, ShowsEveryCaseAndDrawsWhatItHas) {
  CountingPlotter plotter;
  const auto html = page(two_cases(), plotter);

  ASSERT_TRUE(html.has_value());
  EXPECT_THAT(*html, HasSubstr("a &quot;b&quot;"));
  EXPECT_THAT(*html, HasSubstr("failed"));
  std::vector<std::string> ids;
  for (const report::Plot& plot : plotter.drawn) ids.push_back(plot.id);
  EXPECT_THAT(ids, ElementsAre("time-d50-m"));  // over the setting nothing is drawn: its last one is no number
}

TEST(BreakageKernelOfASweep, HasTheRatesAndDaughtersThatItsCasesHad) {
  // Two speeds; every 0.1 s of ten agglomerates of 8 spheres one, or two, are cut in halves.
  std::vector<ResolvedCase> cases(2);
  for (std::size_t k = 0; k < 2; ++k) {
    ResolvedCase& one = cases[k];
    one.name = k == 0 ? "0001" : "0002";
    one.ln_setting = {std::log(k == 0 ? 100.0 : 200.0)};
    one.spheres = 8;
    one.sphere_volume = 1e-9;
    long whole = 1000, halves = 0;
    one.history.push_back({0.0, {{8, whole}}, {}});
    for (int i = 1; i <= 5; ++i) {
      const long split = k == 0 ? 10 : 20;
      whole -= split, halves += 2 * split;
      estimation::FragmentSample sample{0.1 * i, {{4, halves}, {8, whole}}, {}};
      for (long n = 0; n < split; ++n) sample.splits.push_back({8, {4, 4}, "chopper"});
      one.history.push_back(std::move(sample));
    }
    one.records = estimation::records_of(one.history, estimation::size_bounds(8));
  }

  const auto kernel = fit_kernel(cases, {"speed"});

  ASSERT_TRUE(kernel) << kernel.error().message;
  const auto slow = kernel->table(cases[0]), fast = kernel->table(cases[1]);
  EXPECT_NEAR(slow.rate.back(), 0.1, 0.01);  // 10 of 1000 in 0.1 s
  EXPECT_NEAR(fast.rate.back() / slow.rate.back(), 2.0, 0.1);
  ASSERT_EQ(slow.daughters.back().size(), 1u);
  EXPECT_EQ(slow.daughters.back()[0].share, 0.5);
  EXPECT_EQ(slow.daughters.back()[0].number, 2.0);
  EXPECT_NEAR(slow.solid.back(), 8e-9, 1e-18);
  const json::Value file = kernel_file(*kernel, cases[0]);
  const auto read_back = pbm::read_breakage_table(file, "kernel");
  ASSERT_TRUE(read_back) << read_back.error().message;
  EXPECT_EQ(read_back->rate, slow.rate);
}

}  // namespace
}  // namespace granary::sweep
