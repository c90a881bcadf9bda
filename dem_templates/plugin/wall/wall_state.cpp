#include "dem_templates/plugin/wall/wall_state.hpp"

#include <fmt/format.h>

#include <charconv>
#include <iterator>
#include <sstream>

namespace granary::dem {
namespace {

struct Line {
  std::string name, fingerprint;
  double start_angle = 0.0, angle_per_step = 0.0;
  long start_step = 0;
  Wear wear;  ///< of no triangle if there is none
};

// Not with >>, which does not give back every number that was written.
double number_from(std::istream& text) {
  std::string word;
  double value = 0.0;
  if (text >> word) std::from_chars(word.data(), word.data() + word.size(), value);
  return value;
}

std::vector<Line> lines_of(const std::string& state) {
  std::vector<Line> lines;
  std::istringstream text(state);
  for (Line line; text >> line.name >> line.fingerprint;) {
    line.start_angle = number_from(text);
    text >> line.start_step;
    line.angle_per_step = number_from(text);
    std::size_t n_worn = 0;
    text >> n_worn;
    line.wear = Wear(n_worn);
    for (std::vector<double>* volumes : {&line.wear.by_sliding, &line.wear.by_impacts})
      for (double& volume : *volumes) volume = number_from(text);
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

std::string wall_state(const std::vector<WallBody>& bodies, const std::vector<Wear>& wear) {
  std::string state;
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const WallBody& b = bodies[k];
    const Wear& worn = wear.empty() ? Wear() : wear[k];
    state += fmt::format("{} {} {} {} {} {}\n", b.name, b.fingerprint, b.start_angle, b.start_step, b.angle_per_step,
                         worn.by_sliding.size());
    for (const std::vector<double>& volumes : {worn.by_sliding, worn.by_impacts})
      for (const double volume : volumes) fmt::format_to(std::back_inserter(state), "{} ", volume);
    state += '\n';
  }
  return state;
}

Status set_wall_state(const std::string& state, std::vector<WallBody>& bodies, std::vector<Wear>& wear) {
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
    if (!wear.empty() && !lines[b].wear.by_sliding.empty()) wear[b] = lines[b].wear;
  }
  return {};
}

}  // namespace granary::dem
