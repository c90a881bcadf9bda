// Breakage of one and two solids; breakage against aggregation; aggregation in a stirred tank.
#include <fmt/format.h>

#include <cmath>

#include "common/units.hpp"
#include "pbm_solver/verification/density_problem.hpp"
#include "pbm_solver/verification/exact_solutions.hpp"

namespace granary::pbm {
namespace {

Breakage power_breakage(double exponent, double rate = 1.0) {
  Breakage b;
  b.selection = Breakage::Selection::power;
  b.exponent = exponent;
  b.rate = rate;
  return b;
}

DensityProblem problem(const std::string& name, const std::string& text, const Breakage& breakage,
                       std::function<Grid(int)> grid, double end,
                       const std::function<double(double, double)>& density) {
  DensityProblem p;
  p.name = name, p.group = group::kBreakage, p.text = text;
  p.grid = std::move(grid);
  p.breakage = breakage;
  p.end = end;
  p.content = [density](const ClassGrid& g, double t) {
    return exact::cell_content(g, [&](double x, double) { return density(x, t); });
  };
  return p;
}

VerificationCase linear() {
  DensityProblem p = problem("breakage", "rate v, exponential start, t = 4", power_breakage(1.0),
                             even_edges(1e-3, 1e2, false), 4.0, exact::linear_breakage);
  p.moments = {{0, 0, 1.0 + p.end}, {1, 0, 1.0}, {2, 0, 2.0 / (1.0 + p.end)}};
  return make_case(p, "a plain cell average code, as many classes on 1e-2..1e2",
                   {{24, 0.1455, {{"M20", 0.0048}}},
                    {48, 0.0395, {{"M20", 0.0018}}},
                    {96, 0.00865, {{"M20", 0.00088}}},
                    {192, 0.00205, {{"M20", 0.00029}}}},
                   {{"M00", 5e-5}, {"M10", 1e-6}});
}

VerificationCase square() {
  DensityProblem p = problem("breakage-square", "rate v^2, exponential start, t = 4", power_breakage(2.0),
                             even_edges(std::ldexp(1.0, -11), std::ldexp(1.0, 5), false), 4.0, exact::square_breakage);
  // With E = int exp(-t v^2 - v) dv: M0 = 1 + 2 t E, M2 = dM0/dt.
  const double t = p.end, e = 0.5 * std::sqrt(kPi / t) * std::exp(0.25 / t) * std::erfc(0.5 / std::sqrt(t));
  p.moments = {{0, 0, 1.0 + 2.0 * t * e}, {1, 0, 1.0}, {2, 0, e + (1.0 - e) / (2.0 * t)}};
  return make_case(p, kOurs,
                   {{16, 0.093, {{"M20", 0.0030}}}, {32, 0.0202, {{"M20", 0.0014}}}, {64, 0.0044, {{"M20", 0.00053}}}},
                   {{"M00", 2e-3}, {"M10", 1e-6}});
}

VerificationCase one_size() {
  const auto grid = [](int bins) {
    constexpr double kOctaves = 12.0;
    return Grid{{bins, 1}, {std::exp2(-kOctaves), 0.0}, {std::exp2(kOctaves / (bins - 1)), 2.0}};
  };
  DensityProblem p = problem("breakage-one-size", "rate v, one size at the start, t = 4", power_breakage(1.0), grid,
                             4.0, exact::linear_breakage_fragments);
  const auto fragments = p.content;
  p.content = [fragments](const ClassGrid& g, double t) {
    BirthGrid content = fragments(g, t);
    exact::add_particles(g, 1.0, 0.0, std::exp(-t), content);
    return content;
  };
  const double t = p.end;
  p.moments = {{0, 0, 1.0 + t}, {1, 0, 1.0}, {2, 0, 2.0 * (t - 1.0 + std::exp(-t)) / (t * t)}};
  return make_case(p, kOurs,
                   {{13, 0.067, {{"M20", 0.0305}}}, {25, 0.0144, {{"M20", 0.001}}}, {49, 0.0036, {{"M20", 0.0012}}}});
}

VerificationCase broken_in_2d() {
  DensityProblem p = problem("breakage-2d", "two solids, rate 1, exponential start, t = 1", power_breakage(0.0),
                             even_edges(std::ldexp(1.0, -16), std::ldexp(1.0, 4), true), 1.0, {});
  p.content = exact::constant_breakage_2d;
  const double t = p.end, third = std::exp(-t / 3.0);
  p.moments = {{0, 0, std::exp(t)},        {1, 0, 1.0},        {0, 1, 1.0}, {2, 0, 2.0 * third},
               {1, 1, std::exp(-0.5 * t)}, {0, 2, 2.0 * third}};
  return make_case(p, kOurs,
                   {{20, 0.056, {{"M20", 0.0422}}}, {40, 0.0174, {{"M20", 0.001}}}, {80, 0.0085, {{"M20", 0.002}}}},
                   {{"M00", 4e-3}, {"M10", 1e-4}, {"M01", 1e-4}});
}

/// Only the number's growth, M10 + M01 a second, and the solids are known.
VerificationCase linear_2d() {
  DensityProblem p = problem("breakage-2d-sum", "two solids, rate x + y, exponential start, t = 2", power_breakage(1.0),
                             even_edges(std::ldexp(1.0, -16), std::ldexp(1.0, 4), true), 2.0, {});
  p.content = [](const ClassGrid& g, double) {
    return exact::cell_content(g, [](double x, double y) { return std::exp(-x - y); });
  };
  p.moments_only = true;
  p.moments = {{0, 0, 1.0 + 2.0 * p.end}, {1, 0, 1.0}, {0, 1, 1.0}};
  return make_case(p, kOurs, {{20, 0.0, {}}, {40, 0.0, {}}, {80, 0.0, {}}},
                   {{"M00", 4e-3}, {"M10", 1e-4}, {"M01", 1e-4}});
}

VerificationCase balance(const std::string& name, const std::string& text, double s, std::vector<Bound> grids) {
  DensityProblem p =
      problem(name, text, power_breakage(1.0, s), even_edges(std::ldexp(1.0, -14), std::ldexp(1.0, 6), false), 2.0,
              [s](double v, double t) { return exact::balanced(v, s, t); });
  p.group = group::kBoth;
  p.aggregation.emplace();
  const double q = std::sqrt(2.0 * s), tanh = std::tanh(0.5 * q * p.end), m0 = q * (1.0 + q * tanh) / (q + tanh);
  p.moments = {{0, 0, m0}, {1, 0, 1.0}, {2, 0, 2.0 / m0}};
  return make_case(p, kOurs, std::move(grids));
}

VerificationCase balance_gamma() {
  DensityProblem p =
      problem("balance-gamma", "constant kernel and rate v/2, start 4 v exp(-2 v), t = 2", power_breakage(1.0, 0.5),
              even_edges(std::ldexp(1.0, -14), std::ldexp(1.0, 6), false), 2.0, exact::balanced_gamma);
  p.group = group::kBoth;
  p.aggregation.emplace();
  p.moments = {{0, 0, 1.0}, {1, 0, 1.0}};
  return make_case(p, kOurs, {{20, 0.0591, {}}, {40, 0.0161, {}}, {80, 0.0036, {}}});
}

VerificationCase stirred_tank() {
  constexpr double kTurnover = 0.1;
  DensityProblem p;
  p.name = "stirred-tank", p.group = group::kBoth;
  p.text = "constant kernel in a tank fed with exp(-v), 1/10 of it renewed a second, at its steady state";
  p.grid = even_edges(std::ldexp(1.0, -8), std::ldexp(1.0, 10), false);
  p.aggregation.emplace();
  p.turnover = kTurnover;
  p.end = 300.0;
  p.content = [](const ClassGrid& g, double t) {
    return exact::cell_content(
        g, [t](double v, double) { return t == 0.0 ? std::exp(-v) : exact::stirred_tank(v, kTurnover); });
  };
  const double number = std::sqrt(kTurnover * (kTurnover + 2.0)) - kTurnover;
  p.moments = {{0, 0, number}, {1, 0, 1.0}, {2, 0, 2.0 + 1.0 / kTurnover}};
  return make_case(p, kOurs,
                   {{18, 0.039, {{"M20", 0.0852}}}, {36, 0.0114, {{"M20", 0.0199}}}, {72, 0.0026, {{"M20", 0.0076}}}},
                   {{"M00", 2e-5}, {"M10", 2e-5}});
}

}  // namespace

std::vector<VerificationCase> breakage_cases() {
  return {
      linear(),
      square(),
      one_size(),
      broken_in_2d(),
      linear_2d(),
      balance("balance-growing", "constant kernel and rate 0.3 v, exponential start, t = 2", 0.3,
              {{20, 0.062, {{"M20", 0.0171}}}, {40, 0.0151, {{"M20", 0.0026}}}, {80, 0.0033, {{"M20", 0.0013}}}}),
      balance("balance-steady", "constant kernel and rate v/2, exponential start, which then stays; t = 2", 0.5,
              {{20, 0.0564, {{"M20", 0.0195}}}, {40, 0.0148, {{"M20", 0.0024}}}, {80, 0.0033, {{"M20", 0.0013}}}}),
      balance("balance-breaking", "constant kernel and rate 2 v, exponential start, t = 2", 2.0,
              {{20, 0.0568, {{"M20", 0.02}}}, {40, 0.0148, {{"M20", 0.0025}}}, {80, 0.0033, {{"M20", 0.0013}}}}),
      balance("balance-stiff", "constant kernel and rate 50 v, exponential start, t = 2", 50.0,
              {{20, 0.0602, {{"M20", 0.0193}}}, {40, 0.0149, {{"M20", 0.0026}}}, {80, 0.0034, {{"M20", 0.0013}}}}),
      balance_gamma(),
      stirred_tank(),
  };
}

}  // namespace granary::pbm
