// A coupled campaign that fits parameters on the core its DEM leaves idle: real LIGGGHTS, real balances, made small.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

#include "common/files.hpp"
#include "common/results/campaign_results.hpp"
#include "tests/support/killed_campaign.hpp"
#include "tests/support/small_estimation.hpp"

namespace granary::test {
namespace {

/// The programs, but with a DEM that begins a further burst only once idle cores have come to some evaluations: what
/// follows from them is then the same on a machine full of others' work.
fs::path patient_programs(const fs::path& folder) {
  fs::create_directories(folder);
  for (const char* name : {"granary", "granary-pbm", "granary-monitor", "granary-agent"})
    fs::copy_file(kPrograms / name, folder / name);
  std::ofstream(folder / "granary-dem")
      << "#!/bin/sh\nround=$(basename \"$PWD\" | cut -c4)\n"
         "wait_for=$((20 * (round - 1))); k=0\n"
         "while [ \"$(grep -c '\"cost\":[0-9]' ../../estimation/evaluations.jsonl)\" -lt "
         "$wait_for ] && [ $k -lt 2000 ]; do k=$((k+1)); sleep 0.1; done\n"
         "exec "
      << (kPrograms / "granary-dem").string() << " \"$@\"\n";
  fs::permissions(folder / "granary-dem", fs::perms::owner_all);
  return folder / "granary";
}

json::Value case_of(const fs::path& folder) {
  const auto document = json::read_file(folder / "case.json");
  EXPECT_TRUE(document) << (document ? "" : document.error().message);
  return document.value_or(json::Value());
}

TEST(CampaignEstimation, FitsOnIdleCoresAdoptsWhatItKnowsAndRunsTheBalanceOnceMoreWithTheResult) {
  const Scratch scratch;
  const fs::path dir = scratch / "run", program = patient_programs(scratch / "programs");
  auto arguments = small_estimation("run", dir);
  arguments.insert(arguments.begin(), program.string());
  arguments.insert(arguments.end(), {"--json", "--quiet"});
  const auto ran = pilot::run_program(arguments, "", 500.0);
  ASSERT_TRUE(ran) << ran.error().message;
  ASSERT_EQ(0, ran->exit_code) << ran->err;

  const auto results = read_results(dir / "results.h5");
  ASSERT_TRUE(results) << results.error().message;
  const EstimationSummary& estimation = results->estimation;
  EXPECT_EQ(6u, results->bursts.size());
  EXPECT_GT(estimation.used, 0.0);
  EXPECT_GE(estimation.cost.size(), 40u);
  EXPECT_EQ(28u, estimation.data.size());
  EXPECT_EQ(16, std::count_if(estimation.data.begin(), estimation.data.end(),
                              [](const auto& datum) { return datum.held_out == 1; }));

  // What a burst was journalled to adopt is what it ran with; the others took the workflow's own values.
  const auto adopted = records(dir, "estimation.adopted");
  ASSERT_EQ(adopted.size(), estimation.adopted.size());
  std::map<std::string, std::vector<double>> values{
      {"0001-pbm", {0.0005, 0.1}}, {"0002-pbm", {0.0005, 0.1}}, {"0003-pbm", {0.0005, 0.1}}};
  for (const pilot::Record& record : adopted)
    values[record.payload.text_or("burst", "?")] = record.payload.numbers("values");
  ASSERT_EQ(3u, values.size());
  for (const auto& [burst, expected] : values) {
    const json::Value ran_with = case_of(dir / "bursts" / burst);
    EXPECT_EQ(expected.at(0), ran_with["aggregation"].number_or("rate", 0.0)) << burst;
    EXPECT_EQ(expected.at(1), ran_with["breakage"].number_or("rate", 0.0)) << burst;
  }
  EXPECT_NE(0.0005, values["0003-pbm"].at(0)) << "by then a better one was known";

  // The final run: every burst's rates, one set of parameters, the whole process.
  const auto decided = records(dir, "estimation.final");
  ASSERT_EQ(1u, decided.size());
  for (const char* folder : {"final/0001", "final/0002", "final/0003"})
    EXPECT_EQ(decided[0].payload.numbers("values").at(0), case_of(dir / folder)["aggregation"].number_or("rate", 0.0))
        << folder;
  EXPECT_EQ(case_of(dir / "bursts/0002-pbm")["dem"], case_of(dir / "final/0002")["dem"]);
  ASSERT_FALSE(estimation.final_time.empty());
  EXPECT_NEAR(14.0, estimation.final_time.back(), 1e-9);

  // The fit is better than the worst that was tried.
  double before = 0.0, after = 0.0;
  for (const auto& datum : estimation.data)
    if (datum.held_out == 0) after += std::pow((datum.fitted - datum.measured) / datum.error, 2);
  for (const double cost : estimation.cost)
    if (!std::isnan(cost)) before = std::max(before, 2.0 * cost);
  EXPECT_LT(after, before);

  const auto page = read_text(dir / "report.html");
  ASSERT_TRUE(page);
  EXPECT_THAT(*page, testing::HasSubstr("Parameters from data"));
  EXPECT_THAT(*page, testing::HasSubstr("objective-time"));
}

TEST(CampaignEstimation, BeginsWithWhatTheFirstBurstHasCountedWhileItStillRuns) {
  const Scratch scratch;
  const fs::path dir = scratch / "run";
  auto arguments =
      small_estimation("run", dir, {"/coupling/most_rounds=1", "/coupling/least_rounds=1", "/outputs/report=false"});
  arguments.insert(arguments.end(), {"--json", "--quiet"});
  granary_json(arguments);

  double first_filler = 1e300, first_rates = 1e300;
  for (const pilot::Record& record : records(dir, "task.submit"))
    if (record.payload["task"].text_or("name", "").starts_with("estimate-"))
      first_filler = std::min(first_filler, record.wall_time);
  for (const pilot::Record& record : records(dir, "coupling.event"))
    if (record.payload.text_or("event", "") == "dem_exchanged") first_rates = std::min(first_rates, record.wall_time);
  EXPECT_LT(first_filler, first_rates);
  // The rates of the whole burst then make another problem of it.
  EXPECT_TRUE(fs::exists(dir / "estimation/problem-0002.json"));
}

TEST(CampaignEstimation, GoesOnAfterAKillOfThePilotWithWhatItKnew) {
  const Scratch scratch;
  const fs::path dir = scratch / "run";
  ASSERT_NO_FATAL_FAILURE(run_and_kill(small_estimation("run", dir, {}), dir, "bursts/0003-dem/tallies.jsonl", 60.0));
  const auto before = json::LineReader(dir / "estimation/evaluations.jsonl").next();
  ASSERT_TRUE(before);

  const auto summary = granary_json({"resume", dir.string(), "--json", "--quiet"});

  EXPECT_EQ(3, summary.integer_or("pbm_bursts", 0));
  const auto after = json::LineReader(dir / "estimation/evaluations.jsonl").next();
  ASSERT_TRUE(after);
  ASSERT_GE(after->size(), before->size());
  for (std::size_t k = 0; k < before->size(); ++k) EXPECT_EQ((*before)[k], (*after)[k]) << "nothing is done twice";
  EXPECT_EQ(1u, records(dir, "estimation.final").size());
  EXPECT_TRUE(fs::exists(dir / "final/0003/out.h5"));
}

}  // namespace
}  // namespace granary::test
