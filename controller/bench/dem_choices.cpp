#include "controller/bench/dem_choices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/math/percentile.hpp"
#include "controller/bench/dem_cases.hpp"
#include "controller/bench/dem_run.hpp"
#include "controller/bench/dem_tallied.hpp"
#include "controller/bench/estimate.hpp"
#include "dem_templates/render/automatic.hpp"
#include "pilot/schedule/machine.hpp"

namespace granary::bench {
namespace {

namespace fs = std::filesystem;
using json::Value;

constexpr double kDiameter = 0.004;  // [m]
constexpr long kParticles = 1200;
constexpr double kSettle = 0.09;  // [s], three turns
constexpr double kLongSettle = 0.24;
// Two ranks are worth their while with more particles than the other choices have.
constexpr double kRanksDiameter = 0.0024;  // [m]
constexpr long kRanksParticles = 10000;

/// One setting: the case it makes, and what is measured of it.
struct Choice {
  std::string choice, value;
  dem::DemCase dem;
  bool is_reference = false;
  std::vector<std::vector<Value>> tallies;  ///< by seed
  std::vector<double> ms_per_step;          ///< by seed
};

dem::DemCase base_case() {
  dem::DemCase c = mixer_case({{kDiameter, kParticles}});
  c.settle_time = kSettle;
  return c;
}

// The reference first; each list is measured against its own.
std::vector<Choice> all_choices() {
  std::vector<Choice> all;
  for (const double us : {2.0, 4.0, 6.0, 8.0, 10.0, 15.0}) {
    dem::DemCase c = base_case();
    c.time_step = 1e-6 * us;
    all.push_back({"time step", fmt::format("{:g} us", us), c, us == 2.0, {}, {}});
  }
  for (const double mpa : {100.0, 30.0, 8.0, 5.0}) {
    dem::DemCase c = base_case();
    c.contact.young_modulus = 1e6 * mpa;
    c.time_step = dem::automatic_time_step(c);
    all.push_back({"stiffness", fmt::format("{:g} MPa, {:.2g} us", mpa, 1e6 * c.time_step), c, mpa == 100.0, {}, {}});
  }
  for (const double mm : {3.0, 1.0, 2.0, 4.0}) {
    dem::DemCase c = base_case();
    c.skin = 1e-3 * mm;
    all.push_back({"skin", fmt::format("{:g} mm", mm), c, mm == 3.0, {}, {}});
  }
  {
    dem::DemCase c = base_case();  // none stated: granary/skin
    all.push_back({"skin", "auto", c, false, {}, {}});
  }
  for (const double mm : {3.0, 4.0, 5.0, 6.0}) {
    const double d = 1e-3 * mm;
    const long n = std::lround(kParticles * std::pow(kDiameter / d, 3));
    dem::DemCase c = mixer_case({{d, n}});
    c.settle_time = kSettle;
    c.time_step = dem::automatic_time_step(c);
    all.push_back(
        {"coarse graining", fmt::format("{} of {:g} mm, {:.2g} us", n, mm, 1e6 * c.time_step), c, mm == 3.0, {}, {}});
  }
  for (const double s : {kLongSettle, 0.12, 0.06, 0.03, 0.015}) {
    dem::DemCase c = base_case();
    c.settle_time = s;
    all.push_back({"filled at once", fmt::format("settles {:g} ms", 1e3 * s), c, s == kLongSettle, {}, {}});
  }
  return all;
}

// The same mixer on one rank and cut in two across each axis.
std::vector<Choice> rank_grids() {
  std::vector<Choice> all;
  for (const auto& grid : {std::array{1, 1, 1}, {2, 1, 1}, {1, 2, 1}, {1, 1, 2}}) {
    dem::DemCase c = mixer_case({{kRanksDiameter, kRanksParticles}});
    c.settle_time = turn_of(c);
    c.ranks = grid[0] * grid[1] * grid[2];
    c.rank_grid = grid;
    c.time_step = dem::automatic_time_step(c);
    all.push_back({"ranks", fmt::format("{} x {} x {}", grid[0], grid[1], grid[2]), c, c.ranks == 1, {}, {}});
  }
  return all;
}

struct Judged {
  const char *quantity, *key;
};
constexpr Judged kJudged[] = {
    {"collisions", "collision_rate"}, {"impacts", "impact_rate"}, {"impact speed", "impact_speed"}};

Value row_of(const Choice& one, const Choice& reference) {
  const double ms = median(one.ms_per_step), cost = 1e-3 * ms / one.dem.time_step;
  Value row = Value::object({{"choice", one.choice},
                             {"value", one.value},
                             {"is_reference", one.is_reference},
                             {"time_step_s", one.dem.time_step},
                             {"ms_per_step", ms},
                             {"core_s_per_process_s", cost}});
  const auto measured = quantities(one.tallies, 1), by_reference = quantities(reference.tallies, 1);
  for (const Judged& judged : kJudged) {
    const Difference d{"", "", estimate(quantity(by_reference, judged.quantity)),
                       estimate(quantity(measured, judged.quantity))};
    row.set(judged.key, d.b.mean)
        .set(fmt::format("{}_error", judged.key), one.is_reference ? 0.0 : d.relative())
        .set(fmt::format("{}_statistical_error", judged.key),
             one.is_reference ? d.b.relative_error() : d.relative_error());
  }
  return row;
}

/// How far one burst of so many turns is from the mean of all, as a standard deviation: the runs whose skins differ
/// have one physics, so that each is a sample.
void add_burst_lengths(Value& rows, const std::vector<Choice>& all) {
  std::vector<std::vector<Value>> tallies;
  double turn = 0.0, cost = 0.0;
  for (const Choice& one : all) {
    if (one.choice != "skin") continue;
    tallies.insert(tallies.end(), one.tallies.begin(), one.tallies.end());
    turn = turn_of(one.dem);
    if (one.is_reference) cost = 1e-3 * median(one.ms_per_step) / one.dem.time_step;
  }
  if (tallies.empty()) return;
  for (const std::size_t turns : {1U, 2U, 3U, 6U}) {
    if (turns >= tallies.front().size()) break;
    Value row = Value::object({{"choice", "burst length"},
                               {"value", fmt::format("{:g} ms", 1e3 * turn * static_cast<double>(turns))},
                               {"is_reference", false},
                               {"core_s_per_burst", cost * turn * static_cast<double>(turns)}});
    const auto measured = quantities(tallies, turns);
    for (const Judged& judged : kJudged) {
      std::vector<double> bursts;
      for (const auto& run : quantity(measured, judged.quantity).run)
        bursts.insert(bursts.end(), run.begin(), run.end());
      double mean = 0.0, square = 0.0;
      for (const double x : bursts) mean += x / static_cast<double>(bursts.size());
      for (const double x : bursts) square += (x - mean) * (x - mean) / static_cast<double>(bursts.size() - 1);
      const double deviation = std::sqrt(square) / mean;
      row.set(judged.key, mean)
          .set(fmt::format("{}_error", judged.key), deviation)
          .set(fmt::format("{}_statistical_error", judged.key),
               deviation / std::sqrt(2.0 * static_cast<double>(bursts.size() - 1)))
          .set("bursts", bursts.size());
    }
    rows.push(row);
  }
}

}  // namespace

Result<Value> choice_rows(Effort effort, const fs::path& scratch, const Say& say) {
  const auto seeds = static_cast<std::size_t>(by_effort(effort, 2, 3, 8));
  const int turns = by_effort(effort, 3, 6, 12);
  std::vector<Choice> all = all_choices();
  const std::size_t n_counted = all.size();
  GRANARY_TRY(const pilot::Machine machine, pilot::local_machine());
  if (machine.n_cores() > 1)
    for (Choice& one : rank_grids()) all.push_back(std::move(one));
  for (Choice& one : all) {
    one.dem.duration = (one.choice == "ranks" ? turns / 3 : turns) * turn_of(one.dem);
    one.tallies.resize(seeds);
    one.ms_per_step.resize(seeds);
  }
  say(fmt::format("speed against error: {} settings, {} seeds each", all.size(), seeds));
  const auto measure = [&](std::size_t k) -> Status {
    Choice& one = all[k / seeds];
    const std::size_t seed = k % seeds;
    dem::DemCase c = one.dem;
    c.seed += 7919 * static_cast<long>(k);
    if (seed == 0) say(fmt::format("{}: {}", one.choice, one.value));
    GRANARY_TRY(Burst burst, run_burst(c, scratch / fmt::format("choice-{}", k)));
    one.tallies[seed] = std::move(burst.tallies);
    one.ms_per_step[seed] = burst.run.loops.back().ms_per_step();
    return {};
  };
  GRANARY_CHECK(at_once(n_counted * seeds, measure));
  // Ranks wait for one another: one run at a time, with all cores.
  for (std::size_t k = n_counted * seeds; k < all.size() * seeds; ++k) GRANARY_CHECK(measure(k));
  Value rows = Value::array();
  const Choice* reference = nullptr;
  for (const Choice& one : all) {
    if (one.is_reference) reference = &one;
    rows.push(row_of(one, *reference));
  }
  add_burst_lengths(rows, all);
  return rows;
}

}  // namespace granary::bench
