// The solver against exact solutions, on the coarse grids of every case of granary-pbm verify; and the exact solutions
// against the balance they are said to solve.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "common/json/io.hpp"
#include "pbm_solver/verification/exact_solutions.hpp"
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

TEST(ExactSolutions, AreRefusedByAnUnknownName) {
  const auto v = verify("sum-2", 16);

  ASSERT_FALSE(v);
  EXPECT_NE(v.error().message.find("Did you mean"), std::string::npos) << v.error().message;
}

}  // namespace
}  // namespace granary::pbm
