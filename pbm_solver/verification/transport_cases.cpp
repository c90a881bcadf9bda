// What moves without births and deaths: a row of tanks that fills, granules that consolidate, liquid that is sprayed.
// On any grid these are ordinary differential equations, so their errors are those of the time steps alone.
#include <algorithm>
#include <cmath>

#include "pbm_solver/verification/density_problem.hpp"
#include "pbm_solver/verification/exact_solutions.hpp"

namespace granary::pbm {
namespace {

constexpr double kTimeError = 2e-5;
const char* const kTimeSteps = "the time steps alone: twice their tolerance, on every grid";

const auto kGrid = even_edges(std::ldexp(1.0, -8), std::ldexp(1.0, 4), false);

/// exp(-v) at the pivots of a grid.
std::vector<double> exponential(const ClassGrid& grid) {
  return exact::at_pivots(grid, exact::cell_content(grid, [](double v, double) { return std::exp(-v); }));
}

PbmCase closed_case(const std::string& name, int bins, double liquid_per_solid, double gas_per_solid, double end) {
  PbmCase c;
  c.name = name;
  c.grid = kGrid(bins);
  c.compartments.volume = {1.0};
  c.end_time = c.output_every = end;
  const ClassGrid grid(c.grid);
  const std::vector<double> number = exponential(grid);
  for (int i = 0; i < bins; ++i) {
    const double solid = number[grid.index(i, 0)] * grid.solid()[grid.index(i, 0)];
    c.initial.push_back({0, i, 0, number[grid.index(i, 0)], liquid_per_solid * solid, gas_per_solid * solid});
  }
  return c;
}

/// sum |a - b| / sum b
double distance(std::span<const double> a, std::span<const double> b) {
  double off = 0.0, all = 0.0;
  for (std::size_t k = 0; k < b.size(); ++k) off += std::abs(a[k] - b[k]), all += b[k];
  return off / all;
}

Comparison unchanged_number(const ClassGrid& grid, const Snapshot& end) {
  Comparison result;
  result.l1_number = distance(end.number, exponential(grid));
  return result;
}

VerificationCase tanks() {
  constexpr int kTanks = 4;
  constexpr double kTurnover = 0.5, kEnd = 6.0;
  VerificationCase v;
  v.name = "tanks", v.group = group::kTransport;
  v.text = "4 tanks in a row, each renewed every 2 s, fed with exp(-v) from t = 0 on; t = 6";
  v.pbm_case = [](int bins) {
    PbmCase c;
    c.name = "tanks";
    c.grid = kGrid(bins);
    c.compartments = {kTanks, std::vector<double>(kTanks, 1.0), kTanks / kTurnover};
    c.feed.emplace();
    const std::vector<double> number = exponential(ClassGrid(c.grid));
    for (int i = 0; i < bins; ++i) c.feed->classes.push_back({i, 0, kTurnover * number[static_cast<std::size_t>(i)]});
    c.end_time = c.output_every = kEnd;
    return c;
  };
  v.compare = [](const PbmCase&, const ClassGrid& grid, const Snapshot& end) {
    std::vector<double> exact;
    for (int tank = 0; tank < kTanks; ++tank)
      for (const double full : exponential(grid)) exact.push_back(full * exact::tank_filling(tank, kTurnover, kEnd));
    Comparison result;
    result.l1_number = distance(end.number, exact);
    double held = 0.0, all = 0.0;
    for (std::size_t k = 0; k < exact.size(); ++k) held += end.number[k], all += exact[k];
    result.moments = {{"M00", held / all - 1.0}};
    return result;
  };
  return v;
}

/// l_int = l as long as phi g > l: then the porosity of the whole granule decays as an exponential.
VerificationCase porosity() {
  constexpr double kRate = 0.5, kEnd = 4.0, kLiquid = 0.1, kGas = 0.9, kLeastPorosity = 0.2, kStart = 0.5;
  VerificationCase v;
  v.name = "porosity", v.group = group::kTransport;
  v.text = "granules with liquid in their pores consolidate from 0.5 towards 0.2 at 0.5 1/s; t = 4";
  v.pbm_case = [](int bins) {
    PbmCase c = closed_case("porosity", bins, kLiquid, kGas, kEnd);
    c.materials.saturation_factor = 10.0;
    c.consolidation = Consolidation{kRate, kLeastPorosity};
    return c;
  };
  v.compare = [](const PbmCase&, const ClassGrid& grid, const Snapshot& end) {
    Comparison result = unchanged_number(grid, end);
    const double exact = kLeastPorosity + (kStart - kLeastPorosity) * std::exp(-kRate * kEnd);
    double worst = 0.0;
    for (std::size_t k = 0; k < grid.size(); ++k) {
      const double pores = end.liquid[k] + end.gas[k];
      const double here = pores / (end.number[k] * grid.solid()[k] + pores);
      worst = std::max(worst, std::abs(here / exact - 1.0));
    }
    result.moments = {{"porosity", worst}};
    return result;
  };
  return v;
}

VerificationCase liquid() {
  constexpr double kRate = 0.2, kStart = 1.0, kEnd = 4.0;
  VerificationCase v;
  v.name = "liquid", v.group = group::kTransport;
  v.text = "dry granules are sprayed from t = 1 on, each in proportion to its solid; t = 4";
  v.pbm_case = [](int bins) {
    PbmCase c = closed_case("liquid", bins, 0.0, 0.0, kEnd);
    c.spray = Spray{kRate, 0, kStart, 1e300};
    return c;
  };
  v.compare = [](const PbmCase&, const ClassGrid& grid, const Snapshot& end) {
    Comparison result = unchanged_number(grid, end);
    double held = 0.0, solid = 0.0, worst = 0.0;
    for (std::size_t k = 0; k < grid.size(); ++k) held += end.liquid[k], solid += end.number[k] * grid.solid()[k];
    const double exact = kRate * (kEnd - kStart);
    for (std::size_t k = 0; k < grid.size(); ++k)
      worst = std::max(worst, std::abs(end.liquid[k] / (exact * end.number[k] * grid.solid()[k] / solid) - 1.0));
    result.moments = {{"liquid", held / exact - 1.0}, {"liquid of a class", worst}};
    return result;
  };
  return v;
}

}  // namespace

std::vector<VerificationCase> transport_cases() {
  std::vector<VerificationCase> cases{tanks(), porosity(), liquid()};
  for (VerificationCase& v : cases) {
    v.reason = kTimeSteps;
    v.order_of = "";
    for (const char* what : {"M00", "porosity", "liquid", "liquid of a class"}) v.bounds.emplace_back(what, kTimeError);
    for (const int bins : {12, 24, 48}) v.grids.push_back({bins, kTimeError, {}});
  }
  return cases;
}

}  // namespace granary::pbm
