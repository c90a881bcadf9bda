#include "pbm_solver/bench/bench_cases.hpp"

#include <array>
#include <cmath>
#include <random>

#include "common/units.hpp"
#include "pbm_solver/bench/class_table.hpp"
#include "pbm_solver/verification/exact_solutions.hpp"

namespace granary::pbm::bench {
namespace {

constexpr int kOctaves = 16;
constexpr double kSmallest = 5e-16;  // of each solid, as published [m^3]

/// Cells from 2^-9 to 2^7 in units of the mean particle.
Grid unit_grid(int bins) {
  const double ratio = std::exp2(double(kOctaves) / bins), first = 0.5 * (1.0 + ratio) * std::ldexp(1.0, -9);
  return {{bins, bins}, {first, first}, {ratio, ratio}};
}

BenchCase unit_case(int bins, double end, double relative_tolerance) {
  BenchCase b;
  PbmCase& c = b.pbm_case;
  c.grid = unit_grid(bins);
  c.compartments.volume = {1.0};
  c.end_time = c.output_every = end;
  c.relative_tolerance = relative_tolerance;
  c.aggregation = Aggregation{};
  return b;
}

/// One particle of mean volume 1 of each solid, exponentially distributed.
Snapshot exponential_start(const PbmCase& c) {
  const ClassGrid grid(c.grid);
  Snapshot start = initial_snapshot(c, grid);
  start.number = exact::at_pivots(
      grid, exact::cell_content(grid, [](double x, double y) { return exact::constant_kernel_2d(x, y, 0.0); }));
  return start;
}

}  // namespace

BenchCase operator_case(int bins, int compartments, KernelKind kernel, int n_classes) {
  BenchCase b;
  PbmCase& c = b.pbm_case;
  const double ratio = std::exp2(double(kOctaves) / bins);
  c.grid = {{bins, bins}, {kSmallest, kSmallest}, {ratio, ratio}};
  c.compartments = {compartments, std::vector<double>(static_cast<std::size_t>(compartments), 1e-4), {}};
  c.aggregation = Aggregation{};
  if (kernel != KernelKind::constant) set_class_table(c, n_classes, 1.0);
  if (kernel == KernelKind::stokes) c.aggregation->efficiency.model = Efficiency::Model::stokes;

  const ClassGrid grid(c.grid);
  b.start = initial_snapshot(c, grid);
  std::mt19937 random(7);
  const auto uniform = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
  };
  for (std::size_t k = 0; k < b.start.number.size(); ++k) {
    const double solid = grid.solid()[k % grid.size()];
    b.start.number[k] = uniform(0.5, 1.5) * 1e-9 / (solid * static_cast<double>(grid.size()));
    b.start.liquid[k] = b.start.number[k] * solid * uniform(0.1, 0.5);
    b.start.gas[k] = b.start.number[k] * solid * uniform(0.1, 0.5);
  }
  return b;
}

BenchCase row_case() {
  constexpr int kBins = 16, kCompartments = 16;
  BenchCase b = operator_case(kBins, kCompartments, KernelKind::classes, 8);
  PbmCase& c = b.pbm_case;
  c.compartments.residence_time = 49.0;
  c.feed = Feed{};
  for (int k = 0; k < 9; ++k) c.feed->classes.push_back({k, k, 1e6 * std::pow(3.0, -k)});
  c.feed->porosity = 1.0 / 3.0;
  c.end_time = 100.0;
  c.output_every = 1.0;
  return b;
}

BenchCase aggregation_case(int bins, double relative_tolerance) {
  BenchCase b = unit_case(bins, 8.0, relative_tolerance);
  b.start = exponential_start(b.pbm_case);
  return b;
}

BenchCase stiff_case(double exponent, double largest_rate_times_end, double relative_tolerance) {
  BenchCase b = unit_case(16, 8.0, relative_tolerance);
  PbmCase& c = b.pbm_case;
  c.aggregation->rate = 10.0;
  const ClassGrid grid(c.grid);
  Breakage breakage;
  breakage.selection = Breakage::Selection::power;
  breakage.exponent = exponent;
  breakage.rate = largest_rate_times_end / c.end_time / std::pow(grid.solid().back(), exponent);
  c.breakage = breakage;
  b.start = exponential_start(c);
  return b;
}

BenchCase published_case(double relative_tolerance) {
  constexpr std::array<double, 9> kFed{726657587, 286654401, 118218011, 50319795, 20954036,
                                       7345998,   1500147,   76518,     149};
  BenchCase b;
  PbmCase& c = b.pbm_case;
  c.grid = {{16, 16}, {kSmallest, kSmallest}, {3.0, 3.0}};
  constexpr int kCompartments = 16;
  constexpr double kRadius = 0.06, kLength = 0.38, kPart = kPi * kRadius * kRadius * kLength / kCompartments;
  c.compartments = {kCompartments, std::vector<double>(kCompartments, kPart), 49.0};
  c.feed = Feed{};
  for (std::size_t k = 0; k < kFed.size(); ++k)
    c.feed->classes.push_back({static_cast<int>(k), static_cast<int>(k), kFed[k]});
  c.feed->porosity = 1.0 / 3.0;  // gas is half of the solids
  c.spray = Spray{1.458e-6, 0, 25.0, 1e300};
  set_class_table(c, 16, 1.5);
  c.aggregation->efficiency.model = Efficiency::Model::wet;
  c.aggregation->efficiency.value = 0.01;
  // The spray makes a tenth of a particle's volume; at the published 0.2 of it nothing would ever be wet (the published
  // code compares with the liquid's own volume, so that every sprayed particle is).
  c.aggregation->efficiency.least_liquid_fraction = 0.05;
  c.end_time = 100.0;
  c.output_every = 0.2;
  c.relative_tolerance = relative_tolerance;
  b.start = initial_snapshot(c, ClassGrid(c.grid));
  return b;
}

double l1_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double off = 0.0, all = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) off += std::abs(a[k] - b[k]), all += std::abs(b[k]);
  return off / all;
}

}  // namespace granary::pbm::bench
