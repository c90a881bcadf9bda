// Sweeps: cases from a workflow, figures from what the cases left, and the files they are told in.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <set>

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

/// Two speeds with three seeds each, the last without figures so far; others got something at the first.
SweepResults repeated_cases() {
  SweepResults results;
  results.name = "study";
  results.solver = "dem";
  results.settings = {"seed", "impeller"};
  results.seed = 0;
  const std::vector<double> ratio{0.1, 0.2, 0.3, 0.5, 0.7};
  for (std::size_t i = 0; i < 6; ++i) {
    CaseResult one{"000" + std::to_string(i + 1), {std::to_string(i % 3), i < 3 ? "50 rpm" : "300 rpm"}, "finished"};
    if (i < ratio.size()) one.figures = {{"breakage_ratio", ratio[i]}};
    results.cases.push_back(std::move(one));
  }
  results.reference = {{{"50 rpm"}, {{"breakage_ratio", 0.25}}}};
  return results;
}

TEST(SweepResults, HaveAMeanAndAScatterOverSeeds) {
  const SweepResults results = repeated_cases();
  const auto repeats = repeats_of(results);

  ASSERT_EQ(repeats.size(), 2u);
  EXPECT_THAT(conditions_of(results), ElementsAre("impeller"));
  const Spread slow = spread_of(repeats[0], "breakage_ratio"), fast = spread_of(repeats[1], "breakage_ratio");
  EXPECT_EQ(slow.n, 3);
  EXPECT_NEAR(slow.mean, 0.2, 1e-15);
  EXPECT_NEAR(slow.scatter, 0.1, 1e-15);
  EXPECT_EQ(fast.n, 2);
  EXPECT_NEAR(fast.scatter, 0.2 / std::sqrt(2.0), 1e-15);
  EXPECT_TRUE(std::isnan(spread_of({1.0}).scatter));
  EXPECT_THAT(means_csv(results), HasSubstr("impeller,cases,breakage_ratio,breakage_ratio_scatter\n50 rpm,3,0.2"));
  const json::Value document = to_json(results);
  EXPECT_EQ(document["means"].items()[1]["figures"]["breakage_ratio"]["cases"].as_integer(), 2);
  EXPECT_EQ(document["reference"].items()[0]["figures"].number_or("breakage_ratio", 0.0), 0.25);
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

TEST(SweepPage, ShowsMeansWithTheirScatterBesideTheReference) {
  CountingPlotter plotter;
  const auto html = page(repeated_cases(), plotter);

  ASSERT_TRUE(html.has_value());
  EXPECT_THAT(*html, HasSubstr("0.2 ± 0.1"));
  EXPECT_THAT(*html, HasSubstr("Beside the reference"));
  EXPECT_THAT(*html, HasSubstr("-0.05"));
  ASSERT_EQ(plotter.drawn.size(), 1u);
  EXPECT_EQ(plotter.drawn[0].id, "setting-breakage-ratio");
  EXPECT_THAT(plotter.drawn[0].script, HasSubstr("dt 2"));  // the reference, dashed
}

TEST(Sweep, RepeatsEachCaseWithSeedsOfItsOwn) {
  const Campaign once = read("sweep_dem.json"), thrice = read("sweep_dem.json", {"/sweep/repeats=3"});

  ASSERT_EQ(thrice.sweep.cases.size(), 3 * once.sweep.cases.size());
  EXPECT_EQ(thrice.sweep.settings.back().pointer, campaign::kSeedSetting);
  std::set<long> seeds;
  for (std::size_t k = 0; k < 3; ++k) {
    const dem::DemCase& one = thrice.sweep.cases[k].understood->dem_case;
    EXPECT_EQ(one.machine.chopper_speed, once.sweep.cases[0].understood->dem_case.machine.chopper_speed);
    seeds.insert(one.seed);
  }
  EXPECT_EQ(seeds.size(), 3u);
  EXPECT_EQ(thrice.sweep.cases[0].understood->dem_case.seed, once.sweep.cases[0].understood->dem_case.seed);
  EXPECT_EQ(thrice.sweep.cases[3].understood->dem_case.seed, thrice.sweep.cases[0].understood->dem_case.seed);
  EXPECT_THAT(problems({"/sweep/repeats=2"}), HasSubstr("a population balance comes out the same each time"));
  const auto twice = campaign::read_campaign(
      kComplete / "sweep_dem.json",
      {"/sweep/repeats=2", R"(/sweep/grid=[{"setting": "/dem/seed", "values": [10007, 10009]}])"});
  ASSERT_FALSE(twice.has_value());
  EXPECT_THAT(twice.error().message, HasSubstr("/dem/seed is swept already"));
}

TEST(BreakageKernelOfASweep, GoesByWhatHitsWhenAsked) {
  const auto tallies = {line(R"({"speed_edges_m_s": [1, 2, 4], "window_s": 0.5})"),
                        line(R"({"window_s": 0.5, "particles": [[10]], "collision_speed": {"histogram": [3, 1]},
               "loads": {"impeller": {"power_W": 2.0}, "chopper": {"power_W": 0.5}}})")};

  const Impacts impacts = impacts_of(tallies, 2.0);

  EXPECT_DOUBLE_EQ(impacts.on("impeller"), 0.2);
  EXPECT_DOUBLE_EQ(impacts.on("shell"), 0.25);  // stands still: what the bodies that turn bring
  // m v^2 / 4 of 3 at sqrt(2) m/s and 1 at sqrt(8) m/s, of 10 spheres in 0.5 s
  EXPECT_DOUBLE_EQ(impacts.on("particles"), 0.25 * 2.0 * (3 * 2.0 + 8.0) / 10.0 / 0.5);
  EXPECT_EQ(impacts_of({}, 1.0).on("chopper"), 0.0);
}

/// 100 agglomerates of 8 spheres at a speed, of which 20 are split into `daughters` within 0.1 s.
ResolvedCase split_case(double speed, const std::vector<int>& daughters) {
  ResolvedCase one;
  one.ln_setting = {std::log(speed)};
  one.spheres = 8;
  one.sphere_volume = 1e-9;
  one.history = {{0.0, {{8, 100}}, {}}, {0.1, {{8, 80}}, {}}};
  for (int n = 1; n <= 20; ++n) one.history[1].splits.push_back({8, daughters, "chopper", n});
  for (const int daughter : daughters) one.history[1].alive[daughter] += 20;
  one.records = estimation::records_of(one.history, estimation::size_bounds(8));
  return one;
}

TEST(BreakageKernelOfASweep, HasTheDaughtersOfTheNearestSpeeds) {
  const std::vector<ResolvedCase> cases{split_case(100.0, {7, 1}), split_case(400.0, {4, 4})};

  const auto kernel = fit_kernel(cases, {"speed"}, KernelOptions::By::settings);

  ASSERT_TRUE(kernel) << kernel.error().message;
  const auto halves = [&](double speed) {  // of the volume
    double share = 0.0;
    for (const auto& daughter : kernel->table(split_case(speed, {8})).daughters.back())
      if (std::abs(daughter.share - 0.5) < 1e-9) share += daughter.share * daughter.number;
    return share;
  };
  EXPECT_LT(halves(100.0), 0.01);
  EXPECT_NEAR(halves(200.0), 0.5, 1e-9);  // as near to one as to the other
  EXPECT_GT(halves(400.0), 0.99);
  EXPECT_GT(halves(1e6), 0.99);
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
      for (long n = 0; n < split; ++n)
        sample.splits.push_back({8, {4, 4}, "chopper", static_cast<int>((i - 1) * split + n + 1)});
      one.history.push_back(std::move(sample));
    }
    one.records = estimation::records_of(one.history, estimation::size_bounds(8));
  }

  // Of each agglomerate by itself: the first so many are cut in the first interval, and so on.
  for (ResolvedCase& one : cases)
    for (const auto& apart : estimation::by_agglomerate(one.history, 8))
      one.agglomerates.push_back(estimation::sums_of(apart, estimation::size_bounds(8)));
  const auto kernel = fit_kernel(cases, {"speed"}, KernelOptions::By::settings);

  ASSERT_TRUE(kernel) << kernel.error().message;
  const auto slow = kernel->table(cases[0]), fast = kernel->table(cases[1]);
  EXPECT_NEAR(slow.rate.back(), 0.1, 0.01);  // 10 of 1000 in 0.1 s
  EXPECT_NEAR(fast.rate.back() / slow.rate.back(), 2.0, 0.1);
  const auto [low, high] = kernel->causes[0].interval(3);  // of the speed's exponent, which is 1
  EXPECT_GT(kernel->causes[0].replicas.size(), 150u);
  EXPECT_LT(low, 1.0);
  EXPECT_GT(high, 1.0);
  EXPECT_LT(high - low, 2.0);
  const auto rate = kernel->rate(8, cases[0]);
  EXPECT_LT(rate.low, rate.value);
  EXPECT_GT(rate.high, rate.value);
  EXPECT_LT(rate.high / rate.low, 3.0);
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
