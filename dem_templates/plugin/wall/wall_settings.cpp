#include "dem_templates/plugin/wall/wall_settings.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "common/files.hpp"
#include "common/stl.hpp"
#include "dem_templates/plugin/wall/endless_surfaces.hpp"
#include "dem_templates/plugin/wall/mesh_surface.hpp"
#include "dem_templates/plugin/wall/touch_book.hpp"

namespace granary::dem {
namespace {

using Range = FixArguments::Range;
using Words = std::vector<std::string>;

std::string fingerprint_of(std::span<const double> numbers) {
  return fingerprint({reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()});
}

Vector3 vector_at(const std::vector<double>& v, std::size_t first) { return {v[first], v[first + 1], v[first + 2]}; }

// Words first to last of a keyword, as numbers.
std::vector<double> numbers_of(FixArguments& arguments, const std::string& keyword, const Words& words,
                               std::size_t first, std::size_t last) {
  std::vector<double> values;
  for (std::size_t w = first; w < last; ++w) {
    double value = 0.0;
    const char* end = words[w].data() + words[w].size();
    const auto [stop, fault] = std::from_chars(words[w].data(), end, value);
    if (fault != std::errc{} || stop != end || !std::isfinite(value))
      arguments.problem("'" + keyword + " " + words[0] + "': '" + words[w] + "' is no number.");
    values.push_back(value);
  }
  return values;
}

Vector3 direction_of(FixArguments& arguments, const std::string& what, const Vector3& direction) {
  if (norm(direction) > 0.0) return (1.0 / norm(direction)) * direction;
  arguments.problem("'" + what + "': the direction must not be 0 0 0.");
  return {0, 0, 1};
}

bool has_area(const Triangle& t) { return norm(cross(t[1] - t[0], t[2] - t[0])) > 0.0; }

class BodyReader {
 public:
  BodyReader(FixArguments& arguments, std::vector<WallBody>& bodies) : arguments_(arguments), bodies_(bodies) {}

  void mesh(const Words& words, double smooth) {
    auto read = read_stl_triangles(words[1]);
    if (!read) return refuse(words[0], "'mesh " + words[0] + "': " + read.error().message);
    std::vector<Triangle> triangles = std::move(read).value();
    std::erase_if(triangles, [](const Triangle& t) { return !has_area(t); });
    if (triangles.empty())
      return refuse(words[0], "'mesh " + words[0] + "': " + words[1] + ": none of its triangles has an area.");
    const std::string shape = fingerprint_of({triangles[0][0].data(), 9 * triangles.size()});
    add(words[0], std::make_unique<MeshSurface>(std::move(triangles), smooth), shape);
  }

  void plane(const Words& words) {
    const auto v = numbers_of(arguments_, "plane", words, 1, 7);
    const Vector3 normal = direction_of(arguments_, "plane " + words[0], vector_at(v, 3));
    add(words[0], std::make_unique<PlaneSurface>(vector_at(v, 0), normal), fingerprint_of(v));
  }

  void cylinder(const Words& words) {
    const auto v = numbers_of(arguments_, "cylinder", words, 1, 8);
    if (v[6] <= 0.0) arguments_.problem("'cylinder " + words[0] + "': the radius must be above 0.");
    const Vector3 axis = direction_of(arguments_, "cylinder " + words[0], vector_at(v, 3));
    add(words[0], std::make_unique<CylinderSurface>(vector_at(v, 0), axis, v[6]), fingerprint_of(v));
  }

  void rotate(const Words& words) {
    const auto body = std::find_if(bodies_.begin(), bodies_.end(), [&](const auto& b) { return b.name == words[0]; });
    if (body == bodies_.end() && refused_.contains(words[0])) return;  // said already
    if (body == bodies_.end()) return arguments_.problem("'rotate " + words[0] + "': there is no body of that name.");
    const auto v = numbers_of(arguments_, "rotate", words, 1, 7);
    const double value = numbers_of(arguments_, "rotate", words, 8, 9)[0];
    body->rotation.origin = vector_at(v, 0);
    body->rotation.axis = direction_of(arguments_, "rotate " + words[0], vector_at(v, 3));
    if (words[7] == "rpm")
      body->rotation.rate = value * 2.0 * M_PI / 60.0;
    else if (words[7] == "rad/s")
      body->rotation.rate = value;
    else if (words[7] == "period" && value != 0.0)
      body->rotation.rate = 2.0 * M_PI / value;
    else
      arguments_.problem("'rotate " + words[0] + "' ends with '" + words[7] + " " + words[8] +
                         "'; it must be 'rpm N', 'rad/s W' or 'period SECONDS' (not 0).");
  }

 private:
  void add(const std::string& name, std::unique_ptr<Surface> surface, const std::string& shape) {
    for (const WallBody& body : bodies_)
      if (body.name == name) arguments_.problem("two bodies are named '" + name + "'.");
    WallBody& body = bodies_.emplace_back();
    body.name = name;
    body.surface = std::move(surface);
    body.fingerprint = shape;
  }

  void refuse(const std::string& name, const std::string& problem) {
    refused_.insert(name);
    arguments_.problem(problem);
  }

  FixArguments& arguments_;
  std::vector<WallBody>& bodies_;
  std::set<std::string> refused_;  ///< bodies
};

WearSettings read_wear(FixArguments& arguments, const std::vector<WallBody>& bodies) {
  WearSettings wear;
  if (arguments.has("wear_archard")) {
    const auto v = arguments.numbers("wear_archard", Range::positive());
    if (v.size() == 2) wear.archard = v[0] / v[1];
  }
  if (arguments.has("wear_finnie")) wear.finnie = arguments.number("wear_finnie", Range::positive());
  if (wear.on() != arguments.has("wear_file"))
    arguments.problem("'wear_file PREFIX STEPS' and 'wear_archard K H' or 'wear_finnie F' need each other.");
  if (arguments.has("wear_file")) {
    const Words words = arguments.all("wear_file")[0];
    wear.file = words[0];
    const auto [stop, fault] = std::from_chars(words[1].data(), words[1].data() + words[1].size(), wear.every);
    if (fault != std::errc{} || *stop != '\0' || wear.every < 0)
      arguments.problem("'wear_file " + words[0] + "': '" + words[1] + "' is no number of steps, 0 or more.");
  }
  const bool meshes = std::any_of(bodies.begin(), bodies.end(), [](const auto& b) { return b.surface->n_parts() > 0; });
  if (wear.on() && !meshes) arguments.problem("wear is kept for each triangle: it needs a 'mesh'.");
  return wear;
}

}  // namespace

std::vector<FixArguments::Keyword> wall_keywords() {
  return {{"type"},
          {"rolling_friction"},
          {"cohesion"},
          {"push"},
          {"smooth"},
          {"mesh", 2, true},
          {"plane", 7, true},
          {"cylinder", 8, true},
          {"rotate", 9, true},
          {"wear_archard", 2},
          {"wear_finnie"},
          {"wear_file", 2}};
}

WallSettings read_wall_settings(FixArguments& arguments) {
  WallSettings settings;
  settings.type = static_cast<int>(arguments.integer("type", Range::at_least(1)));
  const std::string rolling = arguments.text_or("rolling_friction", "off");
  if (rolling == "epsd2")
    settings.rolling = RollingModel::epsd2;
  else if (rolling == "cdt")
    settings.rolling = RollingModel::cdt;
  else if (rolling != "off")
    arguments.problem("'rolling_friction' is '" + rolling + "'; it must be off, cdt or epsd2.");
  const std::string cohesion = arguments.text_or("cohesion", "off");
  settings.cohesion = cohesion == "sjkr";
  if (!settings.cohesion && cohesion != "off")
    arguments.problem("'cohesion' is '" + cohesion + "'; it must be off or sjkr.");
  const std::string push = arguments.text_or("push", "yes");
  settings.pushes = push == "yes";
  if (!settings.pushes && push != "no") arguments.problem("'push' is '" + push + "'; it must be yes or no.");
  const double smooth = arguments.number_or("smooth", 5.0, Range::not_negative()) * M_PI / 180.0;
  if (smooth > 0.5 * M_PI) arguments.problem("'smooth' must be at most 90 degrees.");

  BodyReader read(arguments, settings.bodies);
  for (const Words& words : arguments.all("mesh")) read.mesh(words, smooth);
  for (const Words& words : arguments.all("plane")) read.plane(words);
  for (const Words& words : arguments.all("cylinder")) read.cylinder(words);
  if (settings.bodies.empty() && !arguments.has("mesh"))
    arguments.problem("needs a body: 'mesh', 'plane' or 'cylinder'.");
  if (settings.bodies.size() > TouchBook::kMostBodies)
    arguments.problem("has " + std::to_string(settings.bodies.size()) + " bodies; one fix takes at most " +
                      std::to_string(TouchBook::kMostBodies) + ": give the others to a second one.");
  for (const Words& words : arguments.all("rotate")) read.rotate(words);
  settings.wear = read_wear(arguments, settings.bodies);
  return settings;
}

}  // namespace granary::dem
