#include "dem_templates/plugin/wall/wall_state.hpp"

#include <fmt/format.h>

#include <charconv>
#include <sstream>

namespace granary::dem {
namespace {

struct Line {
  std::string name;
  std::uint64_t fingerprint = 0;
  double start_angle = 0.0, angle_per_step = 0.0;
  long start_step = 0;
};

std::vector<Line> lines_of(const std::string& state) {
  std::vector<Line> lines;
  std::istringstream text(state);
  std::string start_angle, angle_per_step;
  for (Line line; text >> line.name >> line.fingerprint >> start_angle >> line.start_step >> angle_per_step;) {
    // Not with >>, which does not give back every number that was written.
    std::from_chars(start_angle.data(), start_angle.data() + start_angle.size(), line.start_angle);
    std::from_chars(angle_per_step.data(), angle_per_step.data() + angle_per_step.size(), line.angle_per_step);
    lines.push_back(line);
  }
  return lines;
}

template <class Named>
std::string names_of(const std::vector<Named>& list) {
  std::string names;
  for (const Named& one : list) names += (names.empty() ? "" : ", ") + one.name;
  return names;
}

}  // namespace

std::string wall_state(const std::vector<WallBody>& bodies) {
  std::string state;
  for (const WallBody& b : bodies)
    state += fmt::format("{} {} {} {} {}\n", b.name, b.fingerprint, b.start_angle, b.start_step, b.angle_per_step);
  return state;
}

Status set_wall_state(const std::string& state, std::vector<WallBody>& bodies) {
  const std::vector<Line> lines = lines_of(state);
  bool same_names = lines.size() == bodies.size();
  for (std::size_t b = 0; same_names && b < bodies.size(); ++b) same_names = lines[b].name == bodies[b].name;
  if (!same_names)
    return Error{"the restart file has the bodies " + names_of(lines) + "; the input script has " + names_of(bodies) +
                 ". Give the same ones in the same order, or the fix another ID, to begin without a past."};
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (lines[b].fingerprint != bodies[b].fingerprint)
      return Error{"the shape of body '" + bodies[b].name +
                   "' is not the one that the restart file was written with: what particles remember of it would be "
                   "wrong. Give the same shape, or the fix another ID, to begin without a past."};
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    bodies[b].start_angle = lines[b].start_angle;
    bodies[b].start_step = lines[b].start_step;
    bodies[b].angle_per_step = lines[b].angle_per_step;
  }
  return {};
}

}  // namespace granary::dem
