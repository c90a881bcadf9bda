#include "pbm_solver/output/summary.hpp"

#include <array>

#include "common/math/size_distribution.hpp"

namespace granary::pbm {
namespace {

void add_outlet(const PbmCase& c, const ClassGrid& grid, Fields last, Summary& s) {
  s.outlet_rate.assign(grid.size(), 0.0);
  if (!c.compartments.residence_time) return;
  const double turnover = c.compartments.count / *c.compartments.residence_time;
  for (std::size_t k = 0; k < grid.size(); ++k) {
    s.outlet_rate[k] = turnover * last.number[k];
    s.outlet_number_rate += s.outlet_rate[k];
  }
  const std::array<double, 4> held = holdup(grid, last);
  s.outlet_mass_rate = turnover * (c.materials.solid_density[0] * held[0] + c.materials.solid_density[1] * held[1]);
  const double volume = held[0] + held[1] + held[2] + held[3];
  s.outlet_liquid_fraction = volume > 0.0 ? held[2] / volume : 0.0;
  s.outlet = {s.d10.back(), s.d50.back(), s.d90.back()};
}

}  // namespace

void Sizes::add(const ClassGrid& grid, Fields f) {
  for (std::size_t k = 0; k < grid.size(); ++k) {
    if (!(f.number[k] > 0.0)) continue;
    volume.push_back(grid.solid()[k] * f.number[k] + f.liquid[k] + f.gas[k]);
    diameter.push_back(sphere_diameter(volume.back() / f.number[k]));
  }
}

Quantiles quantiles_of(const Sizes& s, const ClassGrid& grid) {
  const double width = log_width_of_pivots(grid.axis(0).pivots(), grid.axis(1).pivots());
  return {quantile(s.diameter, s.volume, 0.1, width), quantile(s.diameter, s.volume, 0.5, width),
          quantile(s.diameter, s.volume, 0.9, width)};
}

Summary summarize(const Snapshot& snapshot, const PbmCase& c, const ClassGrid& grid) {
  Summary s;
  const std::size_t n = grid.size(), n_compartments = snapshot.number.size() / n;
  for (std::size_t x = 0; x < n_compartments; ++x) {
    const auto part = [&](const std::vector<double>& all) { return std::span(all).subspan(x * n, n); };
    const Fields f{part(snapshot.number), part(snapshot.liquid), part(snapshot.gas)};
    double number = 0.0;
    for (const double one : f.number) number += one;
    const std::array<double, 4> held = holdup(grid, f);
    const double solid = held[0] + held[1], volume = solid + held[2] + held[3];
    Sizes sizes;
    sizes.add(grid, f);
    const Quantiles q = quantiles_of(sizes, grid);
    s.number.push_back(number);
    s.d10.push_back(q.d10), s.d50.push_back(q.d50), s.d90.push_back(q.d90);
    s.solid.push_back(solid), s.liquid.push_back(held[2]), s.gas.push_back(held[3]);
    s.porosity.push_back(volume > 0.0 ? (held[2] + held[3]) / volume : 0.0);
    const double* book = &snapshot.ledger[x * ledger::kSize];
    s.oversize += book[ledger::kOversize] + book[ledger::kOversize + 1];
    if (x + 1 == n_compartments) add_outlet(c, grid, f, s);
  }
  s.drift = drift(snapshot, grid);
  return s;
}

json::Value progress_header(const PbmCase& c, double start_time, int ranks, int threads) {
  return json::Value::object({{"format", "granary-progress-1"},
                              {"compartments", c.compartments.count},
                              {"bins", json::Value(json::Array{c.grid.bins[0], c.grid.bins[1]})},
                              {"start_time_s", start_time},
                              {"end_time_s", c.end_time},
                              {"ranks", ranks},
                              {"threads", threads}});
}

json::Value progress_line(const Snapshot& snapshot, const Summary& s, const Cost& cost) {
  const json::Value outlet = json::Value::object({{"solid_kg_s", s.outlet_mass_rate},
                                                  {"number_1_s", s.outlet_number_rate},
                                                  {"d10_m", s.outlet.d10},
                                                  {"d50_m", s.outlet.d50},
                                                  {"d90_m", s.outlet.d90},
                                                  {"liquid_fraction", s.outlet_liquid_fraction}});
  const json::Value drifts = json::Value::object(
      {{"solid_1", s.drift.solid_1}, {"solid_2", s.drift.solid_2}, {"liquid", s.drift.liquid}, {"gas", s.drift.gas}});
  return json::Value::object({{"time_s", snapshot.time},
                              {"wall_s", cost.wall},
                              {"cpu_s", cost.cpu},
                              {"step_s", snapshot.next_step},
                              {"steps", cost.work.steps},
                              {"rejected", cost.work.rejected},
                              {"rhs_evaluations", cost.work.rhs_evaluations},
                              {"number", s.number},
                              {"d10_m", s.d10},
                              {"d50_m", s.d50},
                              {"d90_m", s.d90},
                              {"solid_m3", s.solid},
                              {"liquid_m3", s.liquid},
                              {"gas_m3", s.gas},
                              {"porosity", s.porosity},
                              {"outlet", outlet},
                              {"drift", drifts},
                              {"oversize_m3", s.oversize}});
}

}  // namespace granary::pbm
