// The solver against exact solutions, on the coarse grids of every case of granary-pbm verify; and the exact solutions
// against the balance they are said to solve.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "common/json/io.hpp"
#include "pbm_solver/time/simulation.hpp"
#include "pbm_solver/verification/convergence_plot.hpp"
#include "pbm_solver/verification/verification.hpp"

namespace granary::pbm {
namespace {

constexpr int kSmall = 40;  // classes along a solid: a test of all cases takes seconds

struct OnGrid {
  std::string name;
  int bins;
};

std::vector<OnGrid> small_grids() {
  std::vector<OnGrid> list;
  for (const VerificationCase& v : verification_cases())
    for (const Bound& grid : v.grids)
      if (grid.bins <= (v.group == group::kTwoSolids ? 32 : kSmall)) list.push_back({v.name, grid.bins});
  return list;
}

/// A row of the table in docs/verification.md, as words: case bins L1 bound order M20 bound M00 drift rhs cpu ok.
using Row = std::vector<std::string>;

std::vector<Row> documented_rows() {
  const std::vector<std::string> names = verification_names();
  std::vector<Row> rows;
  std::ifstream page(std::string(GRANARY_SOURCE_DIR) + "/docs/verification.md");
  for (std::string line; std::getline(page, line);) {
    std::istringstream words(line);
    Row row{std::istream_iterator<std::string>(words), {}};
    if (row.size() == 12 && std::find(names.begin(), names.end(), row[0]) != names.end()) rows.push_back(row);
  }
  return rows;
}

/// In %, as the table prints it.
std::string printed(double bound) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", 100.0 * bound);
  return std::isnan(bound) ? "-" : text;
}

TEST(VerificationPage, HasEveryGridOfEveryCase) {
  std::vector<std::string> known, documented;
  for (const VerificationCase& v : verification_cases())
    for (const Bound& grid : v.grids) known.push_back(v.name + " " + std::to_string(grid.bins));
  for (const Row& row : documented_rows()) {
    documented.push_back(row[0] + " " + row[1]);
    EXPECT_EQ(row[11], "yes") << row[0];
  }

  EXPECT_EQ(documented, known);
}

class ExactSolution : public ::testing::TestWithParam<OnGrid> {};

TEST_P(ExactSolution, IsMetWithinTheBoundsOfItsCase) {
  const auto v = verify(GetParam().name, GetParam().bins);

  ASSERT_TRUE(v) << v.error().message;
  EXPECT_TRUE(v->passed) << json::dump(to_json(*v), 2);
  EXPECT_FALSE(std::isnan(v->l1_bound) && v->moment_bounds.empty()) << "nothing is bounded";
  EXPECT_GE(v->least_number, 0.0);
  for (const Row& row : documented_rows()) {
    if (row[0] != v->name || row[1] != std::to_string(v->bins)) continue;
    EXPECT_EQ(row[3], printed(v->l1_bound)) << "the page has another bound";
    EXPECT_EQ(row[6], printed(v->moment_bound("M20"))) << "the page has another bound";
    if (row[2] != "-" && row[2] != "0.000") {
      const double l1 = std::stod(row[2]) / 100.0;
      EXPECT_NEAR(v->errors.l1_number, l1, 0.02 * l1 + 5e-6) << "the page has another error";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Grids, ExactSolution, ::testing::ValuesIn(small_grids()), [](const auto& test) {
  std::string name = test.param.name + "_" + std::to_string(test.param.bins);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

double order(const char* name, int coarse, int fine) {
  const auto a = verify(name, coarse), b = verify(name, fine);
  return std::log(a->errors.l1_number / b->errors.l1_number) / std::log(static_cast<double>(fine) / coarse);
}

TEST(ExactSolutions, AreApproachedWithTheOrderOfTheCellAverage) {
  EXPECT_GT(order("sum-1d", 40, 120), 1.8);
  EXPECT_GT(order("constant-1d", 37, 110), 1.6);
  EXPECT_GT(order("constant-2d", 16, 32), 1.7);
  EXPECT_GT(order("pure-2d", 16, 32), 1.8);
  EXPECT_GT(order("breakage", 24, 96), 1.9);
  EXPECT_GT(order("balance-stiff", 20, 80), 1.9);
}

TEST(ExactSolutions, AreKeptByTheTimeStepsWithThirdOrder) {
  // On one grid the number's error is the time steps' alone: 100 times the tolerance costs 100^(2/3) times the error or
  // less.
  const auto loose = verify("constant-1d", 40, 1e-3), tight = verify("constant-1d", 40, 1e-5);

  ASSERT_TRUE(loose && tight);
  EXPECT_LT(std::abs(loose->moment("M00")), 1e-3);
  EXPECT_LT(std::abs(tight->moment("M00")), std::abs(loose->moment("M00")) / 20.0);
}

TEST(ExactSolutions, FailInWordsBeyondEachBound) {
  Verification v;
  v.errors = {0.2, 0.2, {{"M00", 1e-3}, {"M20", 0.4}}};
  v.l1_bound = 0.2, v.moment_bounds = {{"M00", 1e-3}, {"M20", 0.4}};
  v.drift.gas = v.drift_bound = 1e-13;
  EXPECT_TRUE(v.faults().empty());

  v.errors.l1_number = std::nan("");
  v.errors.moments[1].second = -0.41;
  v.drift.liquid = 2e-13;
  v.least_number = -1e-9;

  EXPECT_EQ(v.faults().size(), 4u);
  EXPECT_NE(v.faults()[1].find("M20"), std::string::npos) << v.faults()[1];
}

TEST(ExactSolutions, HaveNoBoundsOnOtherGridsButOnWhatIsConserved) {
  const auto v = verify("sum-1d", 41);

  ASSERT_TRUE(v);
  EXPECT_TRUE(std::isnan(v->l1_bound));
  EXPECT_TRUE(v->moment_bounds.empty());
  EXPECT_EQ(v->drift_bound, 1e-13);
  EXPECT_TRUE(v->passed);
}

TEST(ConvergencePlot, HasALineAndAnOrderForEachCase) {
  const auto results = verify_grids("constant-1d", {});
  ASSERT_TRUE(results);
  const auto file = std::filesystem::temp_directory_path() / ("granary-plot-" + std::to_string(getpid()) + ".svg");

  const Status written = write_convergence_plot(*results, file);

  ASSERT_TRUE(written) << written.error().message;
  std::ifstream stream(file);
  const std::string svg{std::istreambuf_iterator<char>(stream), {}};
  std::filesystem::remove(file);
  EXPECT_NE(svg.find("constant-1d  1.8"), std::string::npos);
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
  EXPECT_FALSE(write_convergence_plot(std::span(*results).first(1), file)) << "one grid has no order";
}

TEST(PowerBreakage, IsReadAsWrittenAndIsLinearForExponentOne) {
  const std::vector<VerificationCase> cases = breakage_cases();
  PbmCase c = cases.front().pbm_case(24);
  ASSERT_EQ(c.breakage->selection, Breakage::Selection::power);
  ASSERT_EQ(c.breakage->exponent, 1.0);
  const auto end_of = [](const PbmCase& one) {
    Alone alone(1);
    Simulation simulation(one, initial_snapshot(one, ClassGrid(one.grid)), alone, 1);
    EXPECT_TRUE(simulation.advance(one.end_time));
    return simulation.snapshot().number;
  };
  const std::vector<double> power = end_of(c);
  c.breakage->selection = Breakage::Selection::linear;
  EXPECT_EQ(end_of(c), power);

  c.breakage->selection = Breakage::Selection::power;
  c.breakage->exponent = 2.5;
  const auto read = read_case(to_json(c), "case.json");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->breakage->selection, Breakage::Selection::power);
  EXPECT_EQ(read->breakage->exponent, 2.5);
  EXPECT_NE(end_of(*read), power);
}

TEST(ExactSolutions, AreRefusedByAnUnknownName) {
  const auto v = verify("sum-2", 16);

  ASSERT_FALSE(v);
  EXPECT_NE(v.error().message.find("Did you mean"), std::string::npos) << v.error().message;
}

}  // namespace
}  // namespace granary::pbm
