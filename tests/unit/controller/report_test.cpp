#include "controller/report/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <sstream>

#include "controller/report/figures.hpp"
#include "controller/report/html.hpp"
#include "controller/report/script.hpp"
#include "tests/support/html_check.hpp"
#include "tests/support/results_example.hpp"

namespace granary::report {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Draws nothing: an empty picture that names its plot.
class FakePlotter : public Plotter {
 public:
  Result<std::vector<std::string>> draw(const std::vector<Plot>& plots) override {
    ++calls;
    asked = plots;
    std::vector<std::string> drawings;
    for (const auto& plot : plots) drawings.push_back("<svg><text>picture of " + plot.id + "</text></svg>");
    return drawings;
  }
  int calls = 0;
  std::vector<Plot> asked;
};

class BrokenPlotter : public Plotter {
 public:
  Result<std::vector<std::string>> draw(const std::vector<Plot>&) override {
    return Error{"no pen", Exit::task_failed};
  }
};

std::string page_of(const CampaignResults& results) {
  FakePlotter plotter;
  return report_html(results, plotter).value();
}

std::vector<Figure> all_figures(const CampaignResults& results) {
  std::vector<Figure> all;
  for (const auto& make : {process_figures, size_figures, rate_figures, dem_figures, core_figures})
    for (auto& figure : make(results)) all.push_back(std::move(figure));
  return all;
}

Figure with_id(const std::vector<Figure>& figures, const std::string& id) {
  for (const auto& figure : figures)
    if (figure.plot.id == id) return figure;
  throw std::runtime_error("no figure " + id);
}

/// The rows of a data block in a plot's script.
std::vector<std::vector<double>> data_of(const std::string& script, const std::string& name = "data") {
  const std::string begin = "$" + name + " << EOD\n";
  const auto from = script.find(begin);
  std::istringstream block(script.substr(from + begin.size(), script.find("\nEOD", from) - from - begin.size()));
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(block, line);) {
    std::istringstream cells(line);
    std::vector<double> row;
    for (std::string cell; cells >> cell;) row.push_back(cell == "NaN" ? std::nan("") : std::stod(cell));
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

TEST(Report, IsOneWellFormedPage) {
  EXPECT_EQ(test::what_is_wrong_with_html(page_of(test::example_results())), "");
  EXPECT_EQ(test::what_is_wrong_with_html(page_of(test::awkward_results())), "");
  EXPECT_EQ(test::what_is_wrong_with_html(page_of({})), "");
}

TEST(Report, NeedsNothingFromElsewhere) {
  const std::string page = page_of(test::example_results());

  for (const char* way_out : {"http:", "https:", "//cdn", "src=", "<link", "<script", "@import", "url("})
    EXPECT_THAT(page, Not(HasSubstr(way_out)));
}

TEST(Report, EscapesEveryTextOfTheResults) {
  const std::string page = page_of(test::awkward_results());

  EXPECT_THAT(page, Not(HasSubstr("<b>&")));
  EXPECT_THAT(page, HasSubstr("&lt;b&gt;&amp;&quot;&#39;\\ µm"));
}

TEST(Report, TellsTheReasonOfEverySwitch) {
  const auto results = test::example_results();
  const std::string page = page_of(results);

  ASSERT_EQ(results.bursts.size(), 7u);
  for (const auto& burst : results.bursts) EXPECT_THAT(page, HasSubstr(escaped(burst.reason)));
}

TEST(Report, TellsHowItEndedAndWhereTheTimeWent) {
  auto results = test::example_results();
  results.ended = "limit";
  results.core_use = {2, 100.0, 7.5, 0.875, {{"dem", 80.0, 160.0}, {"pbm", 12.5, 15.0}}};
  const std::string page = page_of(results);

  for (const char* text : {">limit<", "<b>4 + 3</b><span>DEM and PBM bursts", "<b>100 s</b><span>wall time",
                           "<b>80 s</b><span>with DEM running", "<b>12.5 s</b><span>with PBM running",
                           "<b>7.5 s</b><span>with nothing running", "<b>87.5 %</b><span>core use, 2 cores"})
    EXPECT_THAT(page, HasSubstr(text));
}

TEST(Report, HoldsChoicesDriftAndProvenance) {
  auto results = test::example_results();
  results.pbm.drift_liquid.back() = 4.25e-9;
  const std::string page = page_of(results);

  EXPECT_THAT(page, HasSubstr("What was modelled, what was left out, and what each choice is worth"));
  for (const auto& choice : results.choices)
    for (const auto& text : {choice.choice, choice.value, choice.error, choice.cost})
      EXPECT_THAT(page, HasSubstr("<td class=\"t\">" + escaped(text)));
  EXPECT_THAT(page, HasSubstr("4.25 × 10⁻⁹"));
  for (const auto& text : {results.provenance.revision, results.provenance.host, results.provenance.campaign_json,
                           std::string("3.8.0"), std::string("86028157")})
    EXPECT_THAT(page, HasSubstr(escaped(text)));
}

TEST(Report, PutsEachDrawingIntoItsFigure) {
  FakePlotter plotter;
  const std::string page = report_html(test::example_results(), plotter).value();

  EXPECT_EQ(plotter.calls, 1);
  EXPECT_EQ(plotter.asked.size(), 19u);
  for (const auto& plot : plotter.asked) {
    const auto figure = page.find("<figure id=\"" + plot.id + "\"");
    ASSERT_NE(figure, std::string::npos) << plot.id;
    EXPECT_LT(page.find("picture of " + plot.id + "<", figure), page.find("</figure>", figure)) << plot.id;
  }
}

TEST(Report, LeavesOutPlotsWithoutDataAndSaysSo) {
  FakePlotter plotter;
  const std::string page = report_html({}, plotter).value();

  EXPECT_TRUE(plotter.asked.empty());
  EXPECT_THAT(page, Not(HasSubstr("<figure")));
  for (const auto& figure : all_figures({})) {
    EXPECT_FALSE(figure.missing.empty()) << figure.title;
    const auto at = page.find("“" + figure.title + "”");
    ASSERT_NE(at, std::string::npos) << figure.title;
    EXPECT_LT(page.find(figure.missing, at), page.find("</p>", at)) << figure.title;
  }
}

TEST(Report, LeavesOutOnlyWhatIsMissing) {
  auto results = test::example_results();
  results.rates.clear();
  for (auto& row : results.pbm.porosity)
    for (auto& value : row) value = std::nan("");
  std::fill(results.pbm.outlet_solid.begin(), results.pbm.outlet_solid.end(), 0.0);
  FakePlotter plotter;
  const std::string page = report_html(results, plotter).value();

  EXPECT_EQ(plotter.asked.size(), 19u - 4u - 1u - 1u);
  EXPECT_THAT(page, HasSubstr("Left out: “Porosity of the granules”: the results hold no PBM series for it."));
  EXPECT_THAT(page, HasSubstr("“Outflow of solids”: nothing flows out"));
  EXPECT_THAT(page, HasSubstr("no DEM burst gave rates"));
}

TEST(Report, GivesBackThePlottersError) {
  BrokenPlotter plotter;
  const auto page = report_html(test::example_results(), plotter);

  ASSERT_FALSE(page);
  EXPECT_EQ(page.error().message, "no pen");
}

TEST(Figures, NameBothAxesWithUnits) {
  for (const auto& figure : all_figures(test::example_results())) {
    EXPECT_THAT(figure.plot.script, testing::ContainsRegex("set xlabel '[^']+'")) << figure.title;
    if (figure.plot.id != "gantt") {  // its rows are cores, by name
      EXPECT_THAT(figure.plot.script, testing::ContainsRegex("set ylabel '[^']+\\[[^']+\\]'")) << figure.title;
    }
    EXPECT_FALSE(figure.caption.empty()) << figure.title;
  }
}

TEST(Figures, DrawD50InMicrometresOverProcessTime) {
  const auto results = test::example_results();
  const auto figures = process_figures(results);
  const auto rows = data_of(with_id(figures, "d50").plot.script);

  ASSERT_EQ(rows.size(), results.pbm.time.size());
  for (std::size_t t = 0; t < rows.size(); ++t) {  // time, band of the last compartment, one line a compartment
    ASSERT_EQ(rows[t].size(), 1u + 2u + 4u);
    EXPECT_NEAR(rows[t][0], results.pbm.time[t], 1e-5);
    EXPECT_NEAR(rows[t][1], 1e6 * results.pbm.d10[t][3], 1e-3);
    EXPECT_NEAR(rows[t][2], 1e6 * results.pbm.d90[t][3], 1e-3);
    for (std::size_t x = 0; x < 4; ++x) EXPECT_NEAR(rows[t][3 + x], 1e6 * results.pbm.d50[t][x], 1e-3);
  }
}

TEST(Figures, DrawSizeDistributionsWithUnitArea) {
  const auto figures = size_figures(test::example_results());
  const auto rows = data_of(with_id(figures, "sizes-along").plot.script);

  ASSERT_GT(rows.size(), 10u);
  for (std::size_t line = 1; line < rows.front().size(); ++line) {
    double area = 0.0;
    for (const auto& row : rows) area += row[line] * std::log(10.0) / 24.0;  // the example's classes: 24 a decade
    EXPECT_NEAR(area, 1.0, 0.01) << line;                                    // the tails are cut
  }
}

TEST(Figures, DoNotCallTheStartTheEnd) {
  auto results = test::example_results();
  results.sizes.compartments.resize(1);
  results.sizes.when.resize(1);
  results.sizes.time.resize(1);
  results.sizes.outlet.resize(1);
  const auto figures = size_figures(results);

  EXPECT_EQ(figures[0].title, "Size distributions at the start");
  EXPECT_TRUE(figures[1].plot.script.empty());
}

TEST(Figures, DrawAsManyBusyCoreSecondsAsTheTasksUsed) {
  const auto results = test::example_results();
  const auto figures = core_figures(results);
  const auto rows = data_of(with_id(figures, "busy-cores").plot.script);

  double area = 0.0, used = 0.0;
  for (const auto& row : rows) area += row.back() * results.core_use.wall / static_cast<double>(rows.size());
  for (const auto& kind : results.core_use.kinds) used += kind.core_seconds;
  EXPECT_NEAR(area, used, 1e-4 * used);
}

TEST(Figures, MergeThousandsOfShortTasksIntoOneBox) {
  CampaignResults results;
  for (int i = 0; i < 20000; ++i)
    results.timeline.push_back({"e", "estimation", 1, {i % 4}, 0.01 * i, 0.01 * i + 0.0399});
  results.core_use = core_use(results.timeline, 4, 200.1);
  const auto figures = core_figures(results);

  EXPECT_EQ(data_of(with_id(figures, "gantt").plot.script, "estimation").size(), 4u);
}

TEST(Figures, DrawSpeedsOfBurstsWithOtherClassesOnOneAxis) {
  auto results = test::example_results();
  results.rates.resize(2);
  auto& first = results.rates[0].collision_speed;
  first = results.rates[1].collision_speed;
  for (auto& edge : first.edge) edge *= 2.0;  // the same counts at twice the speed

  const auto rows = data_of(with_id(rate_figures(results), "collision-speed").plot.script);

  double mean_first = 0.0, mean_second = 0.0, area_first = 0.0, area_second = 0.0;
  for (const auto& row : rows) {  // the classes are equally wide in ln U
    if (!std::isnan(row[1])) mean_first += row[1] * std::log(row[0]), area_first += row[1];
    if (!std::isnan(row[2])) mean_second += row[2] * std::log(row[0]), area_second += row[2];
  }
  EXPECT_NEAR(mean_first / area_first - mean_second / area_second, std::log(2.0), 0.01);
}

TEST(Figures, KeepPairsThatNeverCollidedOutOfTheMap) {
  auto results = test::example_results();
  results.rates.back().collision_rate[0][5] = results.rates.back().collision_rate[5][0] = 0.0;
  const auto figures = rate_figures(results);

  EXPECT_EQ(data_of(with_id(figures, "collision-map").plot.script, "cells").size(), 34u);
}

TEST(Script, ThinsLongSeriesButKeepsEveryEnd) {
  LinePlot plot;
  for (int i = 0; i < 100000; ++i) plot.x.push_back(i);
  plot.lines = {{"a", "#000000", plot.x, false}};
  plot.breaks = {33334, 66667};
  const auto rows = data_of(line_plot_script(plot));

  EXPECT_LT(rows.size(), 12100u);
  EXPECT_EQ(rows.front()[0], 0.0);
  EXPECT_EQ(rows.back()[0], 99999.0);
  std::map<double, bool> kept;
  for (const auto& row : rows) kept[row[0]] = true;
  for (const double end : {33333.0, 33334.0, 66666.0, 66667.0}) EXPECT_TRUE(kept[end]) << end;
}

TEST(Script, TextsCannotEndTheirCommand) {
  EXPECT_EQ(text_literal("it's"), "'it''s'");
  EXPECT_EQ(text_literal("a'\nsystem 'rm'"), "'a'' system ''rm'''");
}

TEST(Script, ShortensByCharactersNotBytes) {
  EXPECT_EQ(shortened("µµµ", 3), "µµµ");
  EXPECT_EQ(shortened("µµµµ", 3), "µµµ…");
}

TEST(Script, ScalesAxesByThousands) {
  const std::vector<double> large{3.2e8, 1.0}, small{2.7e-6}, plain{12.0}, none{std::nan(""), 0.0};
  EXPECT_EQ(scale_for({&large}).prefix, "10⁶ ");
  EXPECT_EQ(scale_for({&small}).prefix, "10⁻⁶ ");
  EXPECT_DOUBLE_EQ(scale_for({&small}).factor, 1e-6);
  EXPECT_EQ(scale_for({&plain}).prefix, "");
  EXPECT_EQ(scale_for({&none}).factor, 1.0);
}

TEST(Html, EscapesWhatHtmlWouldRead) {
  EXPECT_EQ(escaped("<a href=\"x\">&'\x01</a>\n"), "&lt;a href=&quot;x&quot;&gt;&amp;&#39;\uFFFD&lt;/a&gt;\n");
}

TEST(Html, WritesNumbersAsPeopleReadThem) {
  EXPECT_EQ(number(2310.0), "2310");
  EXPECT_EQ(number(3.2e8), "3.20 × 10⁸");
  EXPECT_EQ(number(1.5e-15), "1.50 × 10⁻¹⁵");
  EXPECT_EQ(number(0.0), "0");
  EXPECT_EQ(number(std::nan("")), "–");
  EXPECT_EQ(duration(0.42), "0.42 s");
  EXPECT_EQ(duration(725.2), "12 min 5 s");
  EXPECT_EQ(duration(12000.0), "3 h 20 min");
  EXPECT_EQ(duration(std::numeric_limits<double>::infinity()), "inf s");
  EXPECT_EQ(diameter(47.31e-6), "47.3 µm");
  EXPECT_EQ(diameter(1.84e-3), "1.84 mm");
  EXPECT_EQ(diameter(0.0), "–");
  EXPECT_EQ(percent(0.873), "87.3 %");
}

}  // namespace
}  // namespace granary::report
