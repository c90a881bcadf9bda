// Each exact solution against the balance it is said to solve: what the balance says its change with time is, by
// quadrature, beside the change itself, by a difference. No solver and no grid in between.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numeric>

#include "pbm_solver/verification/exact_solutions.hpp"

namespace granary::pbm {
namespace {

using Density1d = std::function<double(double v, double t)>;
using Density2d = std::function<double(double x, double y, double t)>;
using Kernel = std::function<double(double v, double w)>;

/// Gauss-Legendre, 5 nodes on each of n pieces.
double integral(const std::function<double(double)>& f, double from, double to, int pieces) {
  constexpr double kNode[] = {0.0, -0.5384693101056831, 0.5384693101056831, -0.906179845938664, 0.906179845938664};
  constexpr double kWeight[] = {0.5688888888888889, 0.47862867049936647, 0.47862867049936647, 0.23692688505618908,
                                0.23692688505618908};
  const double h = (to - from) / pieces;
  double sum = 0.0;
  for (int p = 0; p < pieces; ++p)
    for (int k = 0; k < 5; ++k) sum += 0.5 * h * kWeight[k] * f(from + h * (p + 0.5 + 0.5 * kNode[k]));
  return sum;
}

/// Over [from, infinity) in ln v; from > 0.
double tail(const std::function<double(double)>& f, double from, int pieces = 60) {
  return integral([&](double s) { return std::exp(s) * f(std::exp(s)); }, std::log(from), std::log(3000.0), pieces);
}
double all_of(const std::function<double(double)>& f) { return tail(f, 1e-9, 100); }

double aggregation(const Density1d& n, const Kernel& beta, double v, double t) {
  const double born = 0.5 * integral([&](double u) { return beta(u, v - u) * n(u, t) * n(v - u, t); }, 0.0, v, 40);
  return born - n(v, t) * all_of([&](double u) { return beta(u, v) * n(u, t); });
}

double breakage(const Density1d& n, const std::function<double(double)>& rate, double v, double t, double largest) {
  const auto born = [&](double u) { return 2.0 / u * rate(u) * n(u, t); };
  return (largest > 0.0 ? integral(born, v, largest, 40) : tail(born, v)) - rate(v) * n(v, t);
}

double change(const Density1d& n, double v, double t) { return (n(v, t + 1e-4) - n(v, t - 1e-4)) / 2e-4; }

constexpr double kVolumes[] = {0.05, 0.3, 1.0, 2.5, 6.0};

double one(double, double) { return 1.0; }
double sum(double u, double v) { return u + v; }
double product(double u, double v) { return u * v; }

TEST(ExactFormulas, OfAggregationOfOneSolidSolveTheBalance) {
  struct {
    Density1d density;
    Kernel kernel;
    double t;
  } const cases[] = {{exact::constant_kernel, one, 5.0},
                     {exact::sum_kernel, sum, 1.5},
                     {exact::product_kernel, product, 0.3},
                     {exact::product_kernel, product, 0.4}};
  for (const auto& c : cases)
    for (const double v : kVolumes)
      EXPECT_NEAR(change(c.density, v, c.t), aggregation(c.density, c.kernel, v, c.t), 3e-7) << v << " at " << c.t;
}

TEST(ExactFormulas, OfBreakageSolveTheBalance) {
  const auto linear = [](double v) { return v; };
  const auto square = [](double v) { return v * v; };
  for (const double v : kVolumes) {
    EXPECT_NEAR(change(exact::linear_breakage, v, 1.2), breakage(exact::linear_breakage, linear, v, 1.2, 0.0), 1e-6);
    EXPECT_NEAR(change(exact::square_breakage, v, 1.2), breakage(exact::square_breakage, square, v, 1.2, 0.0), 1e-6);
    if (v >= 1.0) continue;
    // Fragments of one size also come from what is left of it: 2/1 at the rate 1.
    const double t = 1.2, from_whole = 2.0 * std::exp(-t);
    EXPECT_NEAR(change(exact::linear_breakage_fragments, v, t),
                from_whole + breakage(exact::linear_breakage_fragments, linear, v, t, 1.0), 1e-6);
  }
}

TEST(ExactFormulas, OfAggregationAgainstBreakageSolveTheBalance) {
  for (const double s : {0.3, 0.5, 2.0, 50.0}) {
    const Density1d n = [s](double v, double t) { return exact::balanced(v, s, t); };
    const auto rate = [s](double v) { return s * v; };
    for (const double v : kVolumes)
      EXPECT_NEAR(change(n, v, 0.2), aggregation(n, one, v, 0.2) + breakage(n, rate, v, 0.2, 0.0), 2e-4 * s) << s;
  }
  const auto half = [](double v) { return 0.5 * v; };
  for (const double v : kVolumes)
    EXPECT_NEAR(change(exact::balanced_gamma, v, 1.0),
                aggregation(exact::balanced_gamma, one, v, 1.0) + breakage(exact::balanced_gamma, half, v, 1.0, 0.0),
                1e-6);
}

TEST(ExactFormulas, BeginWhereTheyShould) {
  for (const double v : kVolumes) {
    const double start = std::exp(-v);
    EXPECT_NEAR(exact::constant_kernel(v, 0.0), start, 1e-15);
    EXPECT_NEAR(exact::sum_kernel(v, 1e-9), start, 1e-8);
    EXPECT_NEAR(exact::product_kernel(v, 0.0), start, 1e-15);
    EXPECT_NEAR(exact::balanced(v, 2.0, 0.0), start, 1e-15);
    EXPECT_NEAR(exact::linear_breakage(v, 0.0), start, 1e-15);
    EXPECT_NEAR(exact::square_breakage(v, 0.0), start, 1e-15);
    EXPECT_NEAR(exact::balanced_gamma(v, 1e-6), 4.0 * v * std::exp(-2.0 * v), 1e-5);
    EXPECT_NEAR(exact::constant_kernel_2d(v, 0.7, 0.0), start * std::exp(-0.7), 1e-15);
    EXPECT_NEAR(exact::sum_kernel_2d(v, 0.7, 0.0), start * std::exp(-0.7), 1e-15);
    EXPECT_NEAR(exact::product_kernel_2d(v, 0.7, 0.0), 4.0 * std::exp(-2.0 * (v + 0.7)), 1e-15);
    EXPECT_NEAR(exact::constant_kernel_gamma_2d(v, 0.7, 1.0, 5.0, 1e-9),
                exact::constant_kernel_gamma_2d(v, 0.7, 1.0, 5.0, 0.0), 1e-8);
    EXPECT_NEAR(exact::constant_kernel_mixed(v, 0.7, 0.4, 0.0), 0.0, 1e-15);
    EXPECT_NEAR(exact::constant_kernel_pure(v, 0.4, 0.0), 0.4 * start, 1e-15);
  }
}

/// Births of two solids at (x, y) by a kernel of the total volumes.
double born_2d(const Density2d& n, const Kernel& beta, double x, double y, double t) {
  return 0.5 *
         integral(
             [&](double u) {
               return integral([&](double w) { return beta(u + w, x + y - u - w) * n(u, w, t) * n(x - u, y - w, t); },
                               0.0, y, 8);
             },
             0.0, x, 8);
}

double change(const Density2d& n, double x, double y, double t) {
  return (n(x, y, t + 1e-4) - n(x, y, t - 1e-4)) / 2e-4;
}

TEST(ExactFormulas, OfAggregationOfTwoSolidsSolveTheBalance) {
  const Density2d gamma = [](double x, double y, double t) {
    return exact::constant_kernel_gamma_2d(x, y, 1.0, 5.0, t);
  };
  const double t = 0.3;
  struct {
    Density2d density;
    Kernel kernel;
    std::function<double(double v)> loss;  // int beta n, from the number and the solids, which are known
  } const cases[] = {
      {exact::constant_kernel_2d, one, [=](double) { return 2.0 / (2.0 + t); }},
      {gamma, one, [=](double) { return 2.0 / (2.0 + t); }},
      {exact::sum_kernel_2d, sum, [=](double v) { return v * std::exp(-2.0 * t) + 2.0; }},
      {exact::product_kernel_2d, product, [](double v) { return v; }},
  };
  for (const auto& c : cases)
    for (const auto& [x, y] : {std::pair(0.2, 0.9), std::pair(1.5, 0.4), std::pair(2.0, 3.0)}) {
      const double rate = born_2d(c.density, c.kernel, x, y, t) - c.density(x, y, t) * c.loss(x + y);
      EXPECT_NEAR(change(c.density, x, y, t), rate, 1e-7) << x << " " << y;
    }
}

TEST(ExactFormulas, OfPureGranulesSolveTheBalance) {
  const double a = 0.3, b = 1.0 - a, t = 1.4, number = 2.0 / (2.0 + t);
  const Density2d mixed = [=](double x, double y, double s) { return exact::constant_kernel_mixed(x, y, a, s); };
  const Density1d first = [=](double v, double s) { return exact::constant_kernel_pure(v, a, s); };
  const Density1d second = [=](double v, double s) { return exact::constant_kernel_pure(v, b, s); };
  for (const auto& [x, y] : {std::pair(0.2, 0.9), std::pair(1.5, 0.4), std::pair(2.0, 3.0)}) {
    const double of_mixed = born_2d(mixed, one, x, y, t);
    const double with_first = integral([&, y = y](double u) { return first(u, t) * mixed(x - u, y, t); }, 0.0, x, 20);
    const double with_second = integral([&, x = x](double u) { return second(u, t) * mixed(x, y - u, t); }, 0.0, y, 20);
    const double rate = of_mixed + with_first + with_second + first(x, t) * second(y, t) - mixed(x, y, t) * number;
    EXPECT_NEAR(change(mixed, x, y, t), rate, 1e-7) << x << " " << y;
  }
  for (const double v : kVolumes) {
    const double born = 0.5 * integral([&](double u) { return first(u, t) * first(v - u, t); }, 0.0, v, 20);
    EXPECT_NEAR(change(first, v, t), born - first(v, t) * number, 1e-7);
  }
}

TEST(ExactFormulas, OfBreakageOfTwoSolidsSolveTheBalanceOfOneOfThem) {
  // Below x, summed over y, are C particles with dC/dt = C + 2 x int_x^inf m/x', m the density of x'.
  const ClassGrid grid(Grid{{220, 40}, {std::exp2(-18.0), std::exp2(-18.0)}, {std::exp2(0.1), std::exp2(0.55)}});
  const double t = 1.0, h = 1e-3;
  const auto rows = [&](double time) {
    const BirthGrid content = exact::constant_breakage_2d(grid, time);
    std::vector<Birth> sums(220);
    for (int i = 0; i < 220; ++i)
      for (int j = 0; j < 40; ++j) sums[static_cast<std::size_t>(i)] += content.at(i, j);
    return sums;
  };
  const auto before = rows(t - h), now = rows(t), after = rows(t + h);
  double below = 0.0, rate = 0.0, above = 0.0, all = 0.0, volume = 0.0;
  for (const Birth& row : now) above += row.number * row.number / row.solid_1, all += row.number, volume += row.solid_1;
  for (std::size_t i = 0; i < 200; ++i) {
    below += now[i].number, rate += (after[i].number - before[i].number) / (2.0 * h);
    above -= now[i].number * now[i].number / now[i].solid_1;
    EXPECT_NEAR(rate, below + 2.0 * grid.axis(0).lower_edge(static_cast<int>(i) + 1) * above, 3e-3) << i;
  }
  EXPECT_NEAR(all, std::exp(t), 2e-3);
  EXPECT_NEAR(volume, 1.0, 1e-4);
}

TEST(ExactFormulas, OfOneSizeSolveTheDiscreteBalance) {
  struct {
    double (*count)(int k, double t);
    Kernel kernel;
    double t;
  } const cases[] = {{exact::constant_kernel_count, one, 4.0},
                     {exact::sum_kernel_count, sum, 1.0},
                     {exact::product_kernel_count, product, 0.5}};
  for (const auto& c : cases)
    for (int k = 1; k <= 8; ++k) {
      double rate = 0.0;
      for (int i = 1; i < k; ++i) rate += 0.5 * c.kernel(i, k - i) * c.count(i, c.t) * c.count(k - i, c.t);
      for (int j = 1; j < 1000; ++j) rate -= c.kernel(k, j) * c.count(k, c.t) * c.count(j, c.t);
      EXPECT_NEAR((c.count(k, c.t + 1e-4) - c.count(k, c.t - 1e-4)) / 2e-4, rate, 1e-7) << k;
    }
}

TEST(ExactFormulas, OfFlowSolveTheBalance) {
  const double turnover = 0.1;
  const Density1d n = [=](double v, double) { return exact::stirred_tank(v, turnover); };
  for (const double v : kVolumes)
    EXPECT_NEAR(turnover * (std::exp(-v) - n(v, 0.0)) + aggregation(n, one, v, 0.0), 0.0, 1e-7) << v;
  for (int tank = 0; tank < 5; ++tank) {
    const double before = tank == 0 ? 1.0 : exact::tank_filling(tank - 1, 0.5, 3.0);
    const double change =
        (exact::tank_filling(tank, 0.5, 3.0 + 1e-4) - exact::tank_filling(tank, 0.5, 3.0 - 1e-4)) / 2e-4;
    EXPECT_NEAR(change, 0.5 * (before - exact::tank_filling(tank, 0.5, 3.0)), 1e-8);
    EXPECT_EQ(exact::tank_filling(tank, 0.5, 0.0), 0.0);
  }
}

TEST(ExactFormulas, AreWholeOnAGrid) {
  // Number and solids over the cells of a wide grid, against what they must be.
  const ClassGrid grid(Grid{{38, 38}, {3e-4, 3e-4}, {1.45, 1.45}});  // up to 280
  struct {
    Density2d density;
    double t, number, solid_1, solid_2;
  } const cases[] = {
      {exact::constant_kernel_2d, 5.0, 2.0 / 7.0, 1.0, 1.0},
      {exact::sum_kernel_2d, 0.5, std::exp(-1.0), 1.0, 1.0},
      {exact::product_kernel_2d, 0.2, 0.9, 0.5, 0.5},
      {[](double x, double y, double t) { return exact::constant_kernel_gamma_2d(x, y, 1.0, 5.0, t); }, 5.0, 2.0 / 7.0,
       1.0, 5.0},
  };
  for (const auto& c : cases) {
    const BirthGrid content = exact::cell_content(grid, [&](double x, double y) { return c.density(x, y, c.t); });
    Birth sum;
    for (int i = 0; i < 38; ++i)
      for (int j = 0; j < 38; ++j) sum += content.at(i, j);
    EXPECT_NEAR(sum.number, c.number, 1e-5);
    EXPECT_NEAR(sum.solid_1, c.solid_1, 1e-5);
    EXPECT_NEAR(sum.solid_2, c.solid_2, 5e-5);
  }
}

}  // namespace
}  // namespace granary::pbm
