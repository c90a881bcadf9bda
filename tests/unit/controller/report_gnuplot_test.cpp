// The report with the real gnuplot: needs the program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "common/files.hpp"
#include "controller/report/gnuplot.hpp"
#include "controller/report/report.hpp"
#include "tests/support/html_check.hpp"
#include "tests/support/results_example.hpp"

namespace granary::report {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ReportFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("granary-report-" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

std::size_t count(std::string_view text, std::string_view what) {
  std::size_t n = 0;
  for (auto at = text.find(what); at != std::string_view::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

/// 64 cores, one compartment, one class of everything: the other corners.
CampaignResults corner_results() {
  auto results = test::example_results(1, 1);
  results.timeline.clear();
  for (std::int64_t core = 0; core < 64; ++core)
    results.timeline.push_back({"t", "other", 1, {core}, 0.1 * static_cast<double>(core), 20.0});
  results.core_use = core_use(results.timeline, 64, 20.0);
  for (auto& rates : results.rates) {
    rates.diameter.resize(1);
    for (auto* table : {&rates.collisions, &rates.collision_rate, &rates.collision_rate_error})
      *table = {{(*table)[0][0]}};
    rates.impact_rate.resize(1);
    rates.impact_rate_error.resize(1);
  }
  results.rates.resize(1);
  for (auto* rows : {&results.pbm.number, &results.pbm.d50})
    for (auto& row : *rows) row[0] = 0.0;
  return results;
}

TEST_F(ReportFile, IsWrittenFromTheResultsFileAlone) {
  ASSERT_TRUE(write_results(test::example_results(), folder_ / "results.h5"));
  const std::string before = read_text(folder_ / "results.h5").value();

  const auto status = write_report(folder_ / "results.h5", folder_ / "report.html");

  ASSERT_TRUE(status) << status.error().message;
  const std::string page = read_text(folder_ / "report.html").value();
  EXPECT_EQ(test::what_is_wrong_with_html(page), "");
  EXPECT_EQ(count(page, "<svg"), 19u);
  EXPECT_EQ(count(page, "</figure>"), 19u);
  EXPECT_GT(count(page, "<text>comp. 4</text>"), 4u);
  EXPECT_EQ(count(page, "<?xml"), 0u);
  EXPECT_EQ(count(page, "<script"), 0u);
  EXPECT_LT(page.size(), 1'500'000u);
  EXPECT_EQ(read_text(folder_ / "results.h5").value(), before);
}

TEST_F(ReportFile, DrawsWhateverTheResultsHold) {
  GnuplotPlotter gnuplot;
  for (const auto& results :
       {test::awkward_results(), corner_results(), test::example_results(16, 8), CampaignResults{}}) {
    const auto page = report_html(results, gnuplot);
    ASSERT_TRUE(page) << page.error().message;
    EXPECT_EQ(test::what_is_wrong_with_html(*page), "");
  }
}

TEST_F(ReportFile, SaysWhichPackageHasGnuplotAndLeavesTheResultsAlone) {
  ASSERT_TRUE(write_results(test::example_results(), folder_ / "results.h5"));
  const std::string before = read_text(folder_ / "results.h5").value();
  const std::string path = std::getenv("PATH");

  ::setenv("PATH", folder_.c_str(), 1);
  const auto status = write_report(folder_ / "results.h5", folder_ / "report.html");
  ::setenv("PATH", path.c_str(), 1);

  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("gnuplot"));
  EXPECT_THAT(status.error().message, HasSubstr("apt-get install gnuplot-nox"));
  EXPECT_FALSE(fs::exists(folder_ / "report.html"));
  EXPECT_EQ(read_text(folder_ / "results.h5").value(), before);
}

TEST_F(ReportFile, SaysWhatGnuplotSaidWhenItFails) {
  GnuplotPlotter gnuplot;
  const auto drawings = gnuplot.draw({{"good", 300, 200, "plot x\n"}, {"bad", 300, 200, "plot no_such_function(x)\n"}});

  ASSERT_FALSE(drawings);
  EXPECT_THAT(drawings.error().message, HasSubstr("no_such_function"));
}

TEST(Drawings, KeepTheirIdsApart) {
  const auto drawings = split_drawings(
      "<?xml?><svg viewBox='0 0 1 1'><title>t</title><defs><circle id='p'/></defs><use xlink:href='#p' "
      "filter='url(#f)'/></svg>\n<?xml?><svg></svg>",
      {{"a", 1, 1, ""}, {"b", 1, 1, ""}});

  ASSERT_TRUE(drawings);
  EXPECT_EQ(drawings->at(0),
            "<svg viewBox='0 0 1 1'><defs><circle id='a-p'/></defs><use xlink:href='#a-p' filter='url(#a-f)'/></svg>");
  EXPECT_EQ(drawings->at(1), "<svg></svg>");
}

TEST(Drawings, AreAsManyAsWereAskedFor) {
  EXPECT_THAT(split_drawings("<svg></svg>", {{"a", 1, 1, ""}, {"b", 1, 1, ""}}).error().message,
              HasSubstr("\"b\": 1 of 2"));
  EXPECT_FALSE(split_drawings("<svg></svg><svg></svg>", {{"a", 1, 1, ""}}));
}

}  // namespace
}  // namespace granary::report
