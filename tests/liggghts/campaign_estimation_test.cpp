// A coupled campaign that fits parameters on the core its DEM leaves idle: real LIGGGHTS, real balances, made small.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/files.hpp"
#include "common/results/campaign_results.hpp"
#include "pilot/journal/journal.hpp"
#include "tests/support/granary_program.hpp"
#include "tests/support/killed_campaign.hpp"

namespace granary::test {
namespace {

/// quick_estimate with short bursts, three rounds, and a coarse balance: some milliseconds an evaluation, so that a
/// loaded machine comes to many of them too.
std::vector<std::string> small_campaign(const fs::path& dir) {
  std::vector<std::string> arguments{
      "run", (kSource / "workflows/quick_estimate.json").string(), "--dir", dir.string(), "--json", "--quiet"};
  for (const char* setting : {"/dem/longest_burst=\"0.2 s\"", "/coupling/most_rounds=3", "/pbm/bins=12",
                              "/pbm/longest_burst=\"4 s\"", "/pbm/tolerance=0.01", "/process/duration=\"14 s\""}) {
    arguments.emplace_back("--set");
    arguments.emplace_back(setting);
  }
  return arguments;
}

std::vector<pilot::Record> records(const fs::path& dir, const std::string& kind) {
  const auto content = pilot::read_journal(dir / "journal.jsonl");
  EXPECT_TRUE(content) << (content ? "" : content.error().message);
  std::vector<pilot::Record> found;
  if (content)
    std::copy_if(content->records.begin(), content->records.end(), std::back_inserter(found),
                 [&](const pilot::Record& record) { return record.kind == kind; });
  return found;
}

json::Value case_of(const fs::path& folder) {
  const auto document = json::read_file(folder / "case.json");
  EXPECT_TRUE(document) << (document ? "" : document.error().message);
  return document.value_or(json::Value());
}

TEST(CampaignEstimation, FitsOnIdleCoresAdoptsWhatItKnowsAndRunsTheBalanceOnceMoreWithTheResult) {
  const Scratch scratch;
  const fs::path dir = scratch / "run";
  const auto summary = granary_json(small_campaign(dir));

  EXPECT_EQ(3, summary.integer_or("pbm_bursts", 0));
  const auto results = read_results(dir / "results.h5");
  ASSERT_TRUE(results) << results.error().message;
  const EstimationSummary& estimation = results->estimation;
  EXPECT_GT(estimation.used, 0.0);
  EXPECT_EQ(14u, estimation.data.size());
  EXPECT_EQ(2, std::count_if(estimation.data.begin(), estimation.data.end(),
                             [](const auto& datum) { return datum.held_out == 1; }));

  // Fillers get what nobody else wants: on a machine full of others' work that may be nothing.
  if (estimation.cost.size() < 30)
    GTEST_SKIP() << "the cores were not idle: " << estimation.cost.size() << " evaluations came to their end";

  // What a burst was journalled to adopt is what it ran with.
  const auto adopted = records(dir, "estimation.adopted");
  ASSERT_FALSE(adopted.empty());
  ASSERT_EQ(adopted.size(), estimation.adopted.size());
  for (const pilot::Record& record : adopted) {
    const json::Value ran = case_of(dir / "bursts" / record.payload.text_or("burst", "?"));
    EXPECT_EQ(record.payload.numbers("values").at(0), ran["aggregation"].number_or("rate", 0.0));
    EXPECT_EQ(record.payload.numbers("values").at(1), ran["breakage"].number_or("rate", 0.0));
  }
  EXPECT_EQ(0.0005, case_of(dir / "bursts/0001-pbm")["aggregation"].number_or("rate", 0.0)) << "nothing was known yet";

  // The final run: every burst's rates, one set of parameters, the whole process.
  const auto decided = records(dir, "estimation.final");
  ASSERT_EQ(1u, decided.size());
  for (const char* folder : {"final/0001", "final/0002", "final/0003"}) {
    const json::Value ran = case_of(dir / folder);
    EXPECT_EQ(decided[0].payload.numbers("values").at(0), ran["aggregation"].number_or("rate", 0.0)) << folder;
  }
  EXPECT_EQ(case_of(dir / "bursts/0002-pbm")["dem"], case_of(dir / "final/0002")["dem"]);
  ASSERT_FALSE(estimation.final_time.empty());
  EXPECT_NEAR(14.0, estimation.final_time.back(), 1e-9);

  // The fit is better than the start: d50 against the data, the run with the workflow's own values beside it.
  double before = 0.0, after = 0.0;
  for (const auto& datum : estimation.data)
    if (datum.what == "d50, outlet") after += std::pow((datum.fitted - datum.measured) / datum.error, 2);
  for (std::size_t k = 0; k < estimation.cost.size(); ++k)
    if (!std::isnan(estimation.cost[k])) before = std::max(before, 2.0 * estimation.cost[k]);
  EXPECT_LT(after, before);

  const auto page = read_text(dir / "report.html");
  ASSERT_TRUE(page);
  EXPECT_THAT(*page, testing::HasSubstr("Parameters from data"));
  EXPECT_THAT(*page, testing::HasSubstr("objective-time"));
}

TEST(CampaignEstimation, GoesOnAfterAKillOfThePilotWithWhatItKnew) {
  const Scratch scratch;
  const fs::path dir = scratch / "run";
  ASSERT_NO_FATAL_FAILURE(run_and_kill(small_campaign(dir), dir, "bursts/0003-dem/tallies.jsonl", 60.0));
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
