// Lines of tallies.jsonl and progress.jsonl as the programs write them, for tests.
#pragma once

#include <cmath>
#include <vector>

#include "common/json/value.hpp"

namespace granary::test {

inline json::Value a_tally_header(double window = 0.01) {
  return json::Value::object({{"format", "granary-tallies-1"},
                              {"class_edges_m", std::vector<double>{1e-3, 2e-3, 4e-3}},
                              {"compartment_edges_m", std::vector<double>{0.0, 0.1}},
                              {"axis", "x"},
                              {"bodies", std::vector<std::string>{"shell", "impeller"}},
                              {"window_s", window},
                              {"coarse_graining", 20.0}});
}

/// Two classes in one compartment, 1000 and 10 particles.
struct TallyLine {
  double time = 0.01, window = 0.01;
  double collisions = 1000.0, impacts = 500.0, speed = 2.0, thin_speed = 2.0;

  json::Value json() const {
    const auto moments = json::Value::object({{"count", 10}, {"mean", 1.0}, {"ln_mean", 0.0}, {"ln_variance", 0.25}});
    return json::Value::object(
        {{"time_s", time},
         {"window_s", window},
         {"particles", std::vector<std::vector<double>>{{1000.0, 10.0}}},
         {"collisions", std::vector<std::vector<double>>{{collisions - 10.0, 10.0}, {10.0, 0.0}}},
         {"collisions_by_compartment", std::vector<double>{collisions}},
         {"impacts", json::Value::object({{"shell", std::vector<double>{impacts / 2, 0.0}},
                                          {"impeller", std::vector<double>{impacts / 2, 0.0}}})},
         {"collision_speed", moments},
         {"impact_speed", moments},
         {"speed_mean_m_s", std::vector<double>{speed, thin_speed}},
         {"speed_rms_m_s", std::vector<double>{1.1 * speed, 1.1 * thin_speed}}});
  }
};

inline json::Value a_progress_header(int compartments = 2) {
  return json::Value::object({{"format", "granary-progress-1"}, {"compartments", compartments}, {"start_time_s", 0.0}});
}

inline json::Value a_progress_line(double time, const std::vector<double>& d50, const std::vector<double>& number,
                                   const std::vector<double>& solid) {
  return json::Value::object({{"time_s", time}, {"number", number}, {"d50_m", d50}, {"solid_m3", solid}});
}

}  // namespace granary::test
