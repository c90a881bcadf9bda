// Aggregation of one solid: constant, sum and product kernels.
#include <fmt/format.h>

#include <cmath>

#include "pbm_solver/verification/density_problem.hpp"
#include "pbm_solver/verification/exact_solutions.hpp"

namespace granary::pbm {
namespace {

using Density1d = double (*)(double v, double t);

DensityProblem problem_1d(const std::string& name, const std::string& text, Aggregation::Kernel kernel, double smallest,
                          double largest, double end, Density1d density) {
  DensityProblem p;
  p.name = name, p.group = group::kOneSolid, p.text = text;
  p.grid = even_edges(smallest, largest, false);
  p.aggregation.emplace().kernel = kernel;
  p.end = end;
  p.content = [density](const ClassGrid& grid, double t) {
    return exact::cell_content(grid, [=](double x, double) { return density(x, t); });
  };
  return p;
}

VerificationCase constant_1d() {
  DensityProblem p = problem_1d("constant-1d", "constant kernel, exponential start, t = 100",
                                Aggregation::Kernel::constant, 1e-6, 1e5, 100.0, exact::constant_kernel);
  p.moments = {{0, 0, 2.0 / (2.0 + p.end)}, {1, 0, 1.0}, {2, 0, 2.0 + p.end}};
  return make_case(
      p, kPlain, {{37, 0.0505, {{"M20", 0.0015}}}, {73, 0.0155, {{"M20", 0.0105}}}, {110, 0.00735, {{"M20", 0.0075}}}});
}

VerificationCase sum_1d(const std::string& name, const std::string& text, double smallest, double largest,
                        std::vector<Bound> grids) {
  DensityProblem p = problem_1d(name, text, Aggregation::Kernel::sum, smallest, largest, 3.0, exact::sum_kernel);
  p.moments = {{0, 0, std::exp(-p.end)}, {1, 0, 1.0}, {2, 0, 2.0 * std::exp(2.0 * p.end)}};
  return make_case(p, kPlain, std::move(grids));
}

VerificationCase product_1d(int percent, std::vector<Bound> grids) {
  DensityProblem p = problem_1d(fmt::format("product-1d-{}", percent),
                                fmt::format("product kernel, exponential start, at {} % of the gel time 1/2", percent),
                                Aggregation::Kernel::product, 1e-6, 1e6, 0.005 * percent, exact::product_kernel);
  p.moments = {{0, 0, 1.0 - 0.5 * p.end}, {1, 0, 1.0}, {2, 0, 2.0 / (1.0 - 2.0 * p.end)}};
  return make_case(
      p, "M20 on 80 classes: the plain code's; else what this scheme gave when the case was written, and a tenth",
      std::move(grids));
}

/// One size at the start: then the sizes are 1, 2, 3 .., which lie on no grid with a constant ratio; so the moments
/// only.
VerificationCase one_size(const std::string& name, const std::string& text, Aggregation::Kernel kernel, double end,
                          double number, double second, std::vector<Bound> grids) {
  DensityProblem p;
  p.name = name, p.group = group::kOneSolid, p.text = text;
  p.grid = [](int bins) {
    constexpr double kOctaves = 16.0;
    return Grid{{bins, 1}, {1.0, 0.0}, {std::exp2(kOctaves / bins), 2.0}};
  };
  p.aggregation.emplace().kernel = kernel;
  p.end = end;
  p.content = [](const ClassGrid& grid, double) {
    BirthGrid content(grid);
    exact::add_particles(grid, 1.0, 0.0, 1.0, content);
    return content;
  };
  p.moments_only = true;
  p.moments = {{0, 0, number}, {1, 0, 1.0}, {2, 0, second}};
  return make_case(p, "what this scheme gave when the case was written, and a tenth", std::move(grids));
}

}  // namespace

std::vector<VerificationCase> aggregation_cases() {
  using K = Aggregation::Kernel;
  const double t_sum = std::log(5.0);
  return {
      constant_1d(),
      sum_1d("sum-1d", "sum kernel (Golovin), exponential start, t = 3", 1e-6, 1e6,
             {{40, 0.0265, {{"M20", 0.225}}}, {80, 0.00665, {{"M20", 0.095}}}, {120, 0.00315, {{"M20", 0.025}}}}),
      sum_1d("sum-1d-wide", "the same on 15 decades of volume, 5 of size", 1.25e-7, 1.25e8,
             {{24, 0.1695, {{"M20", 0.085}}}, {48, 0.0275, {{"M20", 0.046}}}, {96, 0.00625, {{"M20", 0.0106}}}}),
      product_1d(60,
                 {{40, 0.0515, {{"M20", 0.029}}}, {80, 0.0111, {{"M20", 0.00155}}}, {160, 0.00233, {{"M20", 0.0077}}}}),
      product_1d(80,
                 {{40, 0.0504, {{"M20", 0.113}}}, {80, 0.0105, {{"M20", 0.0305}}}, {160, 0.00213, {{"M20", 0.0233}}}}),
      product_1d(90,
                 {{40, 0.0499, {{"M20", 0.214}}}, {80, 0.0101, {{"M20", 0.0845}}}, {160, 0.00204, {{"M20", 0.048}}}}),
      one_size("constant-one-size", "constant kernel, one size at the start, t = 8", K::constant, 8.0, 0.2, 9.0,
               {{16, 0.0, {{"M20", 0.008}}}, {32, 0.0, {{"M20", 0.0168}}}, {64, 0.0, {{"M20", 0.0028}}}}),
      one_size("sum-one-size", "sum kernel (Borel), one size at the start, t = ln 5", K::sum, t_sum, 0.2, 25.0,
               {{16, 0.0, {{"M20", 0.077}}}, {32, 0.0, {{"M20", 0.0332}}}, {64, 0.0, {{"M20", 0.0048}}}}),
      one_size("product-one-size", "product kernel, one size at the start, at half of the gel time 1", K::product, 0.5,
               0.75, 2.0, {{16, 0.0, {{"M20", 0.0034}}}, {32, 0.0, {{"M20", 0.0178}}}, {64, 0.0, {{"M20", 0.005}}}}),
  };
}

}  // namespace granary::pbm
