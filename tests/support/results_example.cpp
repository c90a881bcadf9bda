#include "tests/support/results_example.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

namespace granary::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Reproducible noise in [-1, 1].
double noise(std::size_t i, std::size_t j = 0) {
  const double x = std::sin(12.9898 * static_cast<double>(i) + 78.233 * static_cast<double>(j)) * 43758.5453;
  return 2.0 * (x - std::floor(x)) - 1.0;
}

Rows filled(std::size_t n_rows, std::size_t length, double start) {
  Rows rows(n_rows, std::vector<double>(length));
  for (auto& row : rows)
    for (auto& value : row) value = start += 0.37;
  return rows;
}

std::vector<double> counted(std::size_t n, double start) {
  std::vector<double> values(n);
  for (auto& value : values) value = start += 0.11;
  return values;
}

/// Median diameter of a compartment at a process time [m].
double median(double time, int compartment, int n_compartments) {
  const double place = (compartment + 1.0) / n_compartments;
  return 41e-6 + 70e-6 * place * (1.0 - std::exp(-time / 9.0));
}

/// Volume shares of a log-normal distribution in the classes between `edge`.
std::vector<double> lognormal_shares(const std::vector<double>& edge, double d50, double sigma) {
  std::vector<double> share;
  const auto below = [&](double d) { return 0.5 * std::erfc(-std::log(d / d50) / (sigma * std::sqrt(2.0))); };
  const double total = below(edge.back()) - below(edge.front());
  for (std::size_t i = 0; i + 1 < edge.size(); ++i) share.push_back((below(edge[i + 1]) - below(edge[i])) / total);
  return share;
}

SpeedHistogram speeds(double median_speed, double sigma, double contacts) {
  SpeedHistogram speed;
  for (int i = 0; i <= 30; ++i) speed.edge.push_back(0.003 * std::pow(10.0, i / 7.5));
  speed.count = lognormal_shares(speed.edge, median_speed, sigma);
  for (std::size_t i = 0; i < speed.count.size(); ++i)
    speed.count[i] = std::round(speed.count[i] * contacts * (1.0 + 0.06 * noise(i)));
  speed.ln_mean = std::log(median_speed);
  speed.ln_sigma = sigma;
  return speed;
}

DemRates rates_of(std::int64_t burst, double growth) {
  DemRates rates;
  rates.burst = burst;
  rates.measured = 0.26;
  for (int k = 0; k < 6; ++k) rates.diameter.push_back(growth * 28e-6 * std::pow(1.38, k));
  for (std::size_t p = 0; p < 6; ++p) {
    rates.collisions.emplace_back();
    rates.collision_rate.emplace_back();
    rates.collision_rate_error.emplace_back();
    for (std::size_t q = 0; q < 6; ++q) {
      const double sum = rates.diameter[p] + rates.diameter[q];
      const double counted =
          std::round(420.0 * std::exp(-0.25 * (static_cast<double>(p) + static_cast<double>(q))) + 6.0);
      const double rate = 1900.0 * sum * sum * sum * (1.0 + 0.08 * noise(p + q, p * q));
      rates.collisions.back().push_back(counted);
      rates.collision_rate.back().push_back(rate);
      rates.collision_rate_error.back().push_back(rate / std::sqrt(counted));
    }
    rates.impact_rate.push_back(14.0 + 2.5 * static_cast<double>(p));
    rates.impact_rate_error.push_back(rates.impact_rate.back() * 0.04);
  }
  rates.collision_speed = speeds(0.31 / growth, 0.95, 9000);
  rates.impact_speed = speeds(1.4 * std::sqrt(growth), 0.8, 5200);
  return rates;
}

/// Adds the rows of one DEM burst that begins at DEM time `start` and lasts `length` [s].
void add_dem_windows(DemSeries& dem, std::int64_t burst, double start, double length, double particles) {
  const auto n = static_cast<std::size_t>(std::lround(length / 0.01));
  for (std::size_t w = 0; w < n; ++w) {
    const double settled = 1.0 - std::exp(-static_cast<double>(w) / 4.0);
    dem.time.push_back(start + 0.01 * static_cast<double>(w + 1));
    dem.burst.push_back(burst);
    dem.particles.push_back(particles - std::floor(static_cast<double>(w) * 0.2));
    dem.collisions.push_back(38000.0 * settled * (1.0 + 0.05 * noise(w, 1)));
    dem.impacts.push_back(
        {5200.0 * settled * (1.0 + 0.06 * noise(w, 2)), 9100.0 * settled * (1.0 + 0.05 * noise(w, 3))});
    dem.torque.push_back({0.09 * settled, 0.31 * settled * (1.0 + 0.02 * noise(w, 6))});
    dem.power.push_back({0.0, 65.0 * settled * (1.0 + 0.02 * noise(w, 6))});
    dem.speed.emplace_back();
    for (std::size_t k = 0; k < 6; ++k)
      dem.speed.back().push_back(settled * (2.1 - 0.12 * static_cast<double>(k)) * (1.0 + 0.03 * noise(w, 9 + k)));
    dem.kinetic_energy.push_back(0.021 * settled * settled * (1.0 + 0.04 * noise(w, 4)));
    dem.largest_overlap.push_back(0.018 + 0.006 * std::abs(noise(w, 5)));
  }
}

/// Adds the rows of one PBM burst over the process time from `start` to `end` [s].
void add_pbm_rows(PbmSeries& pbm, std::int64_t burst, double start, double end, int n_compartments) {
  for (double t = start; t < end + 1e-9; t += 0.2) {
    pbm.time.push_back(t);
    pbm.burst.push_back(burst);
    for (Rows* rows : {&pbm.number, &pbm.d10, &pbm.d50, &pbm.d90, &pbm.porosity, &pbm.solid, &pbm.liquid, &pbm.gas})
      rows->emplace_back();
    for (int x = 0; x < n_compartments; ++x) {
      const double d50 = median(t, x, n_compartments);
      const double solid = 2.69e-5 / n_compartments * 4.0 * (1.0 - std::exp(-(t + 4.0) / (3.0 + 2.0 * x)));
      const double liquid = 0.16 * solid * (1.0 - std::exp(-t / 12.0));
      pbm.d50.back().push_back(d50);
      pbm.d10.back().push_back(0.52 * d50);
      pbm.d90.back().push_back(2.05 * d50);
      pbm.number.back().push_back(solid / (0.52 * d50 * d50 * d50) * 3.1);
      pbm.porosity.back().push_back(0.5 - 0.2 * (1.0 - std::exp(-t / (20.0 - x))));
      pbm.solid.back().push_back(solid);
      pbm.liquid.back().push_back(liquid);
      pbm.gas.back().push_back(0.5 * solid);
    }
    const double outlet = median(t, n_compartments - 1, n_compartments);
    pbm.outlet_d10.push_back(0.52 * outlet);
    pbm.outlet_d50.push_back(outlet);
    pbm.outlet_d90.push_back(2.05 * outlet);
    pbm.outlet_solid.push_back(4.1667e-3 * (1.0 - std::exp(-t / 11.0)));
    pbm.outlet_number.push_back(pbm.outlet_solid.back() / 476.0 / (0.52 * outlet * outlet * outlet));
    pbm.outlet_liquid_fraction.push_back(0.1 * (1.0 - std::exp(-t / 15.0)));
    for (auto* drift : {&pbm.drift_solid_1, &pbm.drift_solid_2, &pbm.drift_liquid, &pbm.drift_gas})
      drift->push_back(2e-15 * t * (1.0 + 0.5 * noise(pbm.time.size())));
    pbm.oversize.push_back(0.0);
  }
}

void add_sizes(SizeDistributions& sizes, const std::string& when, double time, int n_compartments) {
  sizes.when.push_back(when);
  sizes.time.push_back(time);
  sizes.compartments.emplace_back();
  for (int x = 0; x < n_compartments; ++x)
    sizes.compartments.back().push_back(lognormal_shares(sizes.edge, median(time, x, n_compartments), 0.53 + 0.02 * x));
  sizes.outlet.push_back(sizes.compartments.back().back());
}

BurstSummary dem_burst(std::int64_t number, double process_time, double dem_start, double dem_end, int n_compartments) {
  BurstSummary burst{number, "dem", "",   process_time, process_time, dem_start, dem_end, 21.0 + 3.0 * noise(number),
                     2,      0,     40.0, 2310.0,       0.0,          0.0};
  burst.reason = fmt::format("collision rates known to {:.1f} % (5 % asked): more DEM would not change the kernels",
                             3.2 + 0.3 * noise(number));
  burst.d50 = median(process_time, n_compartments / 2, n_compartments);
  burst.particles = 3.2e8 * std::exp(-process_time / 30.0);
  return burst;
}

BurstSummary pbm_burst(std::int64_t number, double start, double end, double dem_time, int n_compartments) {
  BurstSummary burst{number, "pbm", "",   start, end, dem_time, dem_time, 1.4 + 0.2 * noise(number),
                     1,      0,     kNan, kNan,  0.0, 0.0};
  const double before = median(start, n_compartments - 1, n_compartments),
               after = median(end, n_compartments - 1, n_compartments);
  burst.reason = fmt::format("d50 in compartment {} moved by +{:.0f} % ({:.1f} -> {:.1f} um), more than 15 %",
                             n_compartments, 100.0 * (after / before - 1.0), 1e6 * before, 1e6 * after);
  burst.d50 = median(end, n_compartments / 2, n_compartments);
  burst.particles = 3.2e8 * std::exp(-end / 30.0);
  return burst;
}

std::vector<ModelChoice> example_choices() {
  return {
      {"DEM time step", "5 us (3.4 % of the Hertz contact time at 12 m/s)", "collision rate +1.2 ± 0.8 % against 1 us",
       "4.8x cheaper than 1 us"},
      {"Coarse-graining", "DEM particles 40x the real diameter", "not measured", "particles 64000x fewer"},
      {"Young's modulus of the particles", "8 MPa", "largest overlap 2.4 % of the radius (bound 5 %)", "not measured"},
      {"PBM grid", "16 x 16 classes x 4 compartments", "d50 0.7 % against 32 x 32", "14x cheaper than 32 x 32"},
      {"Coupling threshold", "15 %", "not measured", "not measured"},
      {"Liquid bridges", "left out: cohesion enters through the efficiency only", "not measured", "not measured"}};
}

}  // namespace

CampaignResults example_results(int n_compartments, int n_rounds) {
  CampaignResults r;
  r.provenance = {
      "quick",
      "coupled",
      "0.1.0",
      "50b7b0d1c2aa",
      {{"granary", "0.1.0 (50b7b0d1c2aa)"}, {"liggghts", "3.8.0"}, {"open mpi", "4.1.4"}, {"hdf5", "1.10.8"}},
      {{"DEM burst 1", 86028157}, {"DEM burst 3", 86028157}},
      "laptop: 2 cores of AMD EPYC 7B13, 8 GB",
      "2026-11-22T03:00:00Z",
      "2026-11-22T03:02:11Z",
      "{\n  \"kind\": \"coupled\",\n  \"name\": \"quick\",\n  \"pbm\": {\"bins\": [16, 16], \"compartments\": 4},\n  "
      "\"dem\": {\"time_step_s\": 5e-06}\n}\n"};
  r.ended = "steady";
  r.message =
      "no watched property moved by more than 15 % between the last two rounds (largest: d50 in compartment 2, +6 %)";
  r.dem.bodies = {"shell", "impeller"};
  for (int i = 0; i <= 60; ++i) r.sizes.edge.push_back(8e-6 * std::pow(10.0, i / 24.0));
  add_sizes(r.sizes, "start", 0.0, n_compartments);

  double process = 0.0, dem_clock = 0.0, wall = 0.6;
  std::int64_t number = 0;
  for (int round = 0; round <= n_rounds; ++round) {
    const double dem_length = round == 0 ? 0.42 : 0.30;
    r.bursts.push_back(dem_burst(++number, process, dem_clock, dem_clock + dem_length, n_compartments));
    add_dem_windows(r.dem, number, dem_clock, dem_length, 2310.0);
    r.rates.push_back(rates_of(number, 1.0 + 0.15 * round));
    const std::string dem_task = fmt::format("{:04}-dem", number);
    r.timeline.push_back({dem_task, "dem", 1, {0, 1}, wall, wall + r.bursts.back().wall});
    r.timeline.push_back({dem_task + "-monitor", "monitor", 1, {}, wall, wall + r.bursts.back().wall});
    wall += r.bursts.back().wall + 0.15;
    dem_clock += dem_length;
    if (round == n_rounds) break;

    const double process_end = process + 3.0 + 5.0 * round;
    r.bursts.push_back(pbm_burst(number, process, process_end, dem_clock, n_compartments));
    add_pbm_rows(r.pbm, number, process + (round == 0 ? 0.0 : 0.2), process_end, n_compartments);
    add_sizes(r.sizes, fmt::format("after burst {}", number), process_end, n_compartments);
    r.timeline.push_back({fmt::format("{:04}-pbm", number), "pbm", 1, {0}, wall, wall + r.bursts.back().wall});
    r.timeline.push_back(
        {fmt::format("estimate-{}", number), "estimation", 1, {1}, wall + 0.05, wall + r.bursts.back().wall});
    wall += r.bursts.back().wall + 0.15;
    process = process_end;
  }
  add_sizes(r.sizes, "end", process, n_compartments);
  r.core_use = core_use(r.timeline, 2, wall);
  r.choices = example_choices();
  return r;
}

CampaignResults awkward_results() {
  const std::string text = "<b>&\"'\\ \xC2\xB5m\n\ttwo lines; $x %s {^2} \xE2\x9C\x93";
  CampaignResults r;
  r.provenance = {text,
                  "",
                  text,
                  text,
                  {{"a", "1"}, {text, ""}, {"", text}},
                  {{text, std::numeric_limits<std::int64_t>::max()}, {"", -1}},
                  text,
                  text,
                  text,
                  std::string(200000, 'j') + text};
  r.ended = "failed";
  r.message = text;
  r.bursts = {{1, "dem", text, 0.0, 0.1, 0.2, 0.3, 1e-300, 64, -9, kNan, std::numeric_limits<double>::infinity(),
               5e-324, 1.0 / 3.0},
              {std::int64_t{1} << 53, "pbm", "", -0.0, 0.1, 0.2, 0.3, 1e308, 0, 139, 1.0, 0.0, kNan, 0.0}};
  auto& p = r.pbm;
  p.time = counted(5, 0.0);
  p.burst = {2, 2, 2, 4, 4};
  double start = 1.0;
  for (Rows* rows : {&p.number, &p.d10, &p.d50, &p.d90, &p.porosity, &p.solid, &p.liquid, &p.gas})
    *rows = filled(5, 3, start += 100.0);
  for (auto* list :
       {&p.outlet_d10, &p.outlet_d50, &p.outlet_d90, &p.outlet_solid, &p.outlet_number, &p.outlet_liquid_fraction,
        &p.drift_solid_1, &p.drift_solid_2, &p.drift_liquid, &p.drift_gas, &p.oversize})
    *list = counted(5, start += 10.0);
  r.sizes = {counted(8, 1.0),
             {"start", text, "end", ""},
             counted(4, 2.0),
             {filled(3, 7, 1.0), filled(3, 7, 2.0), filled(3, 7, 3.0), filled(3, 7, 4.0)},
             filled(4, 7, 5.0)};
  r.dem = {{"shell", text},   counted(6, 0.0),   {1, 1, 1, 3, 3, 3}, counted(6, 1.0),
           counted(6, 2.0),   filled(6, 2, 3.0), filled(6, 2, 7.0),  filled(6, 2, 8.0),
           filled(6, 9, 4.0), counted(6, 5.0),   counted(6, 6.0)};
  r.dem.speed[2][8] = kNan;
  r.rates = {{1,
              0.25,
              counted(2, 1.0),
              filled(2, 2, 1.0),
              filled(2, 2, 2.0),
              filled(2, 2, 3.0),
              counted(2, 4.0),
              counted(2, 5.0),
              {counted(11, 0.0), counted(10, 1.0), 0.5, 0.25},
              {counted(13, 0.0), counted(12, 1.0), -0.5, 1.25}},
             {12345,
              kNan,
              counted(3, 1.0),
              filled(3, 3, 1.0),
              filled(3, 3, 2.0),
              filled(3, 3, 3.0),
              counted(3, 4.0),
              counted(3, 5.0),
              {{}, {}, 0.0, 0.0},
              {counted(2, 0.0), {7.0}, 0.0, 0.0}}};
  r.timeline = {{text, "dem", 1, {0, 1, 63}, 0.0, 1.5}, {"m", "monitor", 2, {}, 0.5, 1.0}};
  r.core_use = {64, 1.5, 0.25, 0.03125, {{"dem", 1.5, 4.5}, {"monitor", 0.5, 0.0}, {text, 0.0, 0.0}}};
  r.choices = {{text, "1", "not measured", ""}};
  auto& e = r.estimation;
  e.parameters = {{text, "/pbm/aggregation/rate", "1/s", 1e-300, 1e308, 0.5, 0.25, kNan, kNan},
                  {"", text, text, -1.0, 1.0, 0.0, 0.125, -0.5, 0.5}};
  e.correlation = filled(2, 2, 1.0);
  e.data = {{text, "m", 1.0, 85e-6, 1e-6, kNan, 1}, {"", "", 2.0, 0.0, 1e-300, 3.0, 0}};
  e.time = counted(4, 0.0);
  e.cost = {1.0, kNan, 0.5, 0.25};
  e.version = {1, 1, 2, 3};
  e.adopted_by = {"0002-pbm", text, ""};
  e.adopted_time = counted(3, 1.0);
  e.adopted = filled(3, 2, 2.0);
  e.final_time = counted(2, 0.0);
  e.final_d10 = counted(2, 1.0);
  e.final_d50 = counted(2, 2.0);
  e.final_d90 = counted(2, 3.0);
  e.warnings = {text};
  e.phase = "search";
  e.misfit = 1.5;
  e.held_out = kNan;
  e.used = 0.5;
  e.left = 0.25;
  e.coupled_wall = 1.25;
  return r;
}

}  // namespace granary::test
