#include "controller/bench/dem_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "controller/bench/dem_cases.hpp"
#include "controller/bench/dem_run.hpp"
#include "controller/bench/dem_tallied.hpp"
#include "dem_templates/render/automatic.hpp"

namespace granary::bench {
namespace {

namespace fs = std::filesystem;
using json::Value;

constexpr double kChance = 1e-3;  // of a false alarm in a comparison

struct ComparedCase {
  std::string name;
  dem::DemCase stock, ours;
  int turns;  ///< measured
};

ComparedCase by_walls(std::string name, dem::DemCase dem, int turns) {
  dem::DemCase stock = dem;
  stock.walls = dem::Walls::stock;
  return {std::move(name), std::move(stock), std::move(dem), turns};
}

/// The mixer whose ten seconds overheads() times: its own steps against stock walls at half of them and less.
ComparedCase ten_seconds(int turns) {
  dem::DemCase dem = ten_seconds_mixer();
  dem.name = "bench-ten-seconds";
  dem.time_step = 5e-6;
  ComparedCase one = by_walls("", dem, turns);
  one.ours.time_step = dem::automatic_time_step(dem);
  one.name = fmt::format("cm5, 2300 particles of the ten seconds; stock at {:g} us, ours at {:g} us",
                         1e6 * one.stock.time_step, 1e6 * one.ours.time_step);
  return one;
}

std::vector<ComparedCase> compared_cases(Effort effort) {
  dem::DemCase mixer = working_mixer({{0.003, 500}, {0.004, 450}, {0.005, 250}});
  dem::DemCase bowl = bowl_case({{0.0025, 350}, {0.003, 300}, {0.004, 150}});
  mixer.time_step = 8e-6;
  bowl.time_step = 8e-6;
  mixer.settle_time = bowl.settle_time = 0.1;
  const int turns = by_effort(effort, 3, 5, 10);
  return {by_walls("cm5, 15 kg/h, 2000 rpm", mixer, turns),
          by_walls("batch bowl, 1200 rpm, chopper 3000 rpm", bowl, turns), ten_seconds(turns)};
}

}  // namespace

std::size_t Comparison::freedom() const {
  if (all.empty()) return 0;
  const auto of = [](const Estimate& e) {
    return e.runs > 1 ? e.batches - e.batches / e.runs : e.batches - std::min<std::size_t>(1, e.batches);
  };
  return of(all.front().a) + of(all.front().b);
}

const Difference& Comparison::worst() const {
  static const Difference none;
  const auto found = std::max_element(all.begin(), all.end(), [](const Difference& x, const Difference& y) {
    return std::abs(x.z()) < std::abs(y.z());
  });
  return found != all.end() ? *found : none;
}

Result<Comparison> compare(const dem::DemCase& a, const dem::DemCase& b, int seeds, const fs::path& scratch,
                           const std::vector<std::string>& only) {
  const auto n = static_cast<std::size_t>(seeds);
  std::array<std::vector<std::vector<Value>>, 2> tallies{std::vector<std::vector<Value>>(n),
                                                         std::vector<std::vector<Value>>(n)};
  const auto measure = [&](std::size_t k) -> Status {
    const std::size_t which = k / n;  // a's runs first: stock walls take longest
    dem::DemCase c = which == 0 ? a : b;
    c.seed += 7919 * static_cast<long>(k);  // no run shares its fill with another
    GRANARY_TRY(Burst burst, run_burst(c, scratch / fmt::format("{}-{}", c.name, k)));
    tallies[which][k % n] = std::move(burst.tallies);
    return {};
  };
  GRANARY_CHECK(at_once(2 * n, measure));
  Comparison comparison{differences(quantities(tallies[0], 1), quantities(tallies[1], 1))};
  if (!only.empty())
    std::erase_if(comparison.all,
                  [&](const Difference& d) { return std::find(only.begin(), only.end(), d.name) == only.end(); });
  return comparison;
}

Result<Comparison> compare_walls(const dem::DemCase& dem_case, int seeds, const fs::path& scratch,
                                 const std::vector<std::string>& only) {
  const ComparedCase one = by_walls("", dem_case, 0);
  return compare(one.stock, one.ours, seeds, scratch, only);
}

Result<Value> comparison_rows(Effort effort, const fs::path& scratch, const Say& say) {
  Value rows = Value::array();
  const int seeds = by_effort(effort, 2, 4, 8);
  for (ComparedCase& one : compared_cases(effort)) {
    say(fmt::format("{}: rates and speeds with stock walls and with ours, {} seeds each", one.name, seeds));
    one.stock.duration = one.ours.duration = one.turns * turn_of(one.ours);
    GRANARY_TRY(const Comparison compared, compare(one.stock, one.ours, seeds, scratch));
    const double allowed = compared.allowed_z(kChance);
    rows.push(Value::object({{"case", one.name},
                             {"seeds", seeds},
                             {"stock_time_step_s", one.stock.time_step},
                             {"granary_time_step_s", one.ours.time_step},
                             {"measured_s_each", one.ours.duration},
                             {"batch_s", one.ours.tally.window},
                             {"largest_z", std::abs(compared.worst().z())},
                             {"largest_z_of", compared.worst().name},
                             {"allowed_z", allowed},
                             {"agree", std::abs(compared.worst().z()) <= allowed},
                             {"quantities", to_json(compared.all)}}));
  }
  return rows;
}

}  // namespace granary::bench
