#include "controller/bench/dem_tallied.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace granary::bench {
namespace {

using json::Value;

/// Sums over the windows of a batch.
struct Batch {
  double seconds = 0.0, windows = 0.0, particles = 0.0, left = 0.0;  ///< particles: sum of the windows' means
  std::vector<std::vector<double>> collisions;
  std::vector<double> impacts, speed, axial;
  double hard_impacts = 0.0, collision_count = 0.0, collision_speed = 0.0, impact_count = 0.0, impact_speed = 0.0;
};

void add(std::vector<double>& sum, const std::vector<double>& more, double weight = 1.0) {
  sum.resize(std::max(sum.size(), more.size()), 0.0);
  for (std::size_t i = 0; i < more.size(); ++i) sum[i] += weight * more[i];
}

void add_speeds(const Value& speeds, double& count, double& sum) {
  count += speeds.number_or("count", 0.0);
  sum += speeds.number_or("count", 0.0) * speeds.number_or("mean", 0.0);
}

void add_window(Batch& batch, const Value& line, std::size_t first_hard) {
  batch.seconds += line.number_or("window_s", 0.0);
  batch.windows += 1.0;
  batch.left += line.number_or("left", 0.0);
  for (const Value& compartment : line["particles"].items_or_none())
    for (const double n : compartment.numbers()) batch.particles += n;
  const auto& rows = line["collisions"].items_or_none();
  batch.collisions.resize(rows.size());
  for (std::size_t p = 0; p < rows.size(); ++p) add(batch.collisions[p], rows[p].numbers());
  for (const auto& [body, counts] : line["impacts"].members_or_none()) add(batch.impacts, counts.numbers());
  add(batch.speed, line.numbers("speed_mean_m_s"));
  add(batch.axial, line.numbers("axial_velocity_m_s"));
  const std::vector<double> histogram = line["impact_speed"].numbers("histogram");
  for (std::size_t h = first_hard; h < histogram.size(); ++h) batch.hard_impacts += histogram[h];
  add_speeds(line["collision_speed"], batch.collision_count, batch.collision_speed);
  add_speeds(line["impact_speed"], batch.impact_count, batch.impact_speed);
}

/// Name and unit of each quantity with its value in this batch.
std::vector<std::tuple<std::string, std::string, double>> values_of(const Batch& b) {
  std::vector<std::tuple<std::string, std::string, double>> all;
  const auto put = [&](std::string name, const char* unit, double value) {
    all.emplace_back(std::move(name), unit, value);
  };
  const double inside = b.particles / b.windows, particle_seconds = inside * b.seconds;
  double collisions = 0.0, impacts = 0.0;
  for (std::size_t p = 0; p < b.collisions.size(); ++p)
    for (std::size_t q = p; q < b.collisions.size(); ++q) {
      put(fmt::format("collisions {}-{}", p + 1, q + 1), "1/s", b.collisions[p][q] / b.seconds);
      collisions += b.collisions[p][q];
    }
  put("collisions", "1/s per particle", collisions / particle_seconds);
  put("collision speed", "m/s", b.collision_speed / std::max(1.0, b.collision_count));
  for (std::size_t p = 0; p < b.impacts.size(); ++p) {
    put(fmt::format("impacts {}", p + 1), "1/s", b.impacts[p] / b.seconds);
    impacts += b.impacts[p];
  }
  put("impacts", "1/s per particle", impacts / particle_seconds);
  put("impacts above 1 m/s", "1/s per particle", b.hard_impacts / particle_seconds);
  put("impact speed", "m/s", b.impact_speed / std::max(1.0, b.impact_count));
  for (std::size_t p = 0; p < b.speed.size(); ++p) put(fmt::format("speed {}", p + 1), "m/s", b.speed[p] / b.windows);
  for (std::size_t x = 0; x < b.axial.size(); ++x)
    put(fmt::format("axial velocity {}", x + 1), "m/s", b.axial[x] / b.windows);
  put("outflow", "1/s per particle", b.left / particle_seconds);
  return all;
}

}  // namespace

std::vector<Measured> quantities(const std::vector<std::vector<Value>>& tallies, std::size_t per_batch) {
  std::vector<Measured> all;
  for (std::size_t s = 0; s < tallies.size(); ++s) {
    const std::vector<double> edges = tallies[s].front().numbers("speed_edges_m_s");
    const auto first_hard = static_cast<std::size_t>(std::lower_bound(edges.begin(), edges.end(), 1.0) - edges.begin());
    for (std::size_t first = 1; first + per_batch <= tallies[s].size(); first += per_batch) {
      Batch batch;
      for (std::size_t w = first; w < first + per_batch; ++w) add_window(batch, tallies[s][w], first_hard);
      for (const auto& [name, unit, value] : values_of(batch)) {
        auto found = std::find_if(all.begin(), all.end(), [&name = name](const Measured& m) { return m.name == name; });
        if (found == all.end()) found = all.insert(all.end(), Measured{name, unit, {}});
        found->run.resize(tallies.size());
        found->run[s].push_back(value);
      }
    }
  }
  std::erase_if(all, [](const Measured& m) {
    return std::all_of(m.run.begin(), m.run.end(), [](const auto& run) {
      return std::all_of(run.begin(), run.end(), [](double v) { return v == 0; });
    });
  });
  return all;
}

const Measured& quantity(const std::vector<Measured>& all, std::string_view name) {
  static const Measured none;
  const auto found = std::find_if(all.begin(), all.end(), [&](const Measured& m) { return m.name == name; });
  return found != all.end() ? *found : none;
}

}  // namespace granary::bench
