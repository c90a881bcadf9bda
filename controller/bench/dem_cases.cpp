#include "controller/bench/dem_cases.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/units.hpp"
#include "dem_templates/geometry/machine.hpp"

namespace granary::bench {
namespace {

constexpr double kFeed = 15.0 / 3600.0;  // [kg/s], as published
constexpr int kCompartments = 4;

// A run that is to be compared must go on to its end: what both codes do is looked at, not bounded.
constexpr dem::Guard kLoose{
    .largest_overlap = 0.95, .overlapping_fraction = 0.5, .energy_factor = 100.0, .lost_fraction = 0.5};

/// `n` things shared out in proportion to `weight`, all of them.
std::vector<long> shares(long n, const std::vector<double>& weight) {
  const double total = std::accumulate(weight.begin(), weight.end(), 0.0);
  std::vector<long> share;
  double cumulated = 0.0;
  long given = 0;
  for (const double w : weight) {
    cumulated += w;
    share.push_back(std::lround(static_cast<double>(n) * cumulated / total) - given);
    given += share.back();
  }
  return share;
}

void put_in(dem::DemCase& c, const Fill& fill) {
  const auto edges = dem::compartment_edges(c.machine, kCompartments);
  const auto room = dem::compartment_volume(c.machine, kCompartments);
  c.population.resize(kCompartments);
  std::vector<double> diameters;
  for (const auto& [diameter, count] : fill) {
    const auto share = shares(count, room);
    diameters.push_back(diameter);
    for (std::size_t x = 0; x < c.population.size(); ++x) {
      c.population[x].from = edges[x];
      c.population[x].to = edges[x + 1];
      c.population[x].diameter.push_back(diameter);
      c.population[x].count.push_back(share[x]);
    }
  }
  std::sort(diameters.begin(), diameters.end());
  c.tally.class_edges = {0.5 * diameters.front()};
  for (std::size_t i = 1; i < diameters.size(); ++i)
    c.tally.class_edges.push_back(0.5 * (diameters[i - 1] + diameters[i]));
  c.tally.class_edges.push_back(2.0 * diameters.back());
}

}  // namespace

dem::DemCase mixer_case(const Fill& fill, double turn, int refinement) {
  dem::DemCase c;
  c.name = "bench-cm5";
  c.machine.mixer.outlet_open = false;
  c.machine.impeller_speed = 2.0 * kPi / turn;
  c.machine.refinement = refinement;
  c.tally.window = turn;
  c.guard = kLoose;
  put_in(c, fill);
  return c;
}

dem::DemCase ten_seconds_mixer() {
  dem::DemCase c = mixer_case({{0.004, 2300}});
  c.settle_time = 0.06;
  return c;
}

dem::DemCase working_mixer(const Fill& fill) {
  dem::DemCase c = mixer_case(fill);
  c.machine.mixer.outlet_open = true;
  c.feed_rate = kFeed;
  return c;
}

dem::DemCase bowl_case(const Fill& fill) {
  dem::DemCase c;
  c.name = "bench-bowl";
  c.machine.type = dem::Machine::Type::batch_bowl;
  c.machine.impeller_speed = 2.0 * kPi * 1200.0 / 60.0;
  c.machine.chopper_speed = 2.0 * kPi * 3000.0 / 60.0;
  c.tally.window = turn_of(c);
  c.guard = kLoose;
  put_in(c, fill);
  return c;
}

double turn_of(const dem::DemCase& c) { return 2.0 * kPi / c.machine.impeller_speed; }

}  // namespace granary::bench
