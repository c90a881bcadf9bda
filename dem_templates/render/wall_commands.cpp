#include "dem_templates/render/wall_commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/units.hpp"
#include "dem_templates/render/render.hpp"
#include "dem_templates/templates.hpp"

namespace granary::dem {
namespace {

bool turns(const Body& body) { return body.rotation && body.rotation->speed != 0.0; }
bool nothing_turns(const std::vector<Body>& all) { return std::none_of(all.begin(), all.end(), turns); }

std::string vector_text(Vec3 v) { return fmt::format("{} {} {}", v.x, v.y, v.z); }

/// The bodies of a granary/wall.
std::string own_bodies(const std::vector<Body>& all) {
  std::string bodies;
  for (const Body& body : all) {
    bodies += fmt::format(" &\n          mesh {0} meshes/{0}.stl", body.name);
    if (turns(body))
      bodies += fmt::format(" rotate {} {} {} rad/s {}", body.name, vector_text(body.rotation->point),
                            vector_text(unit(body.rotation->axis)), body.rotation->speed);
  }
  return bodies;
}

Result<std::string> own_walls(const DemCase& c, const std::vector<Body>& all) {
  std::string bodies = own_bodies(all);
  bodies += fmt::format(
      "\n\n# Neighbour lists, made anew as seen from a frame that turns with the bed.\n"
      "fix lists all granary/lists axis {}",
      "xyz"[static_cast<std::size_t>(axis_of(c.machine))]);
  if (c.ranks > 1) bodies += "\n\n# Each rank as much to do.\nfix balance all granary/balance";
  return render(templates::walls, "walls.tmpl", {{"bodies", bodies}, {"rolling", rolling_style(c)}});
}

Result<std::string> stock_walls(const DemCase& c, const std::vector<Body>& all) {
  std::vector<std::string> meshes, moves, names;
  for (const Body& body : all) {
    names.push_back(body.name);
    meshes.push_back(fmt::format("fix {0} all mesh/surface file meshes/{0}.stl type 2", body.name));
    if (!turns(body)) continue;
    // `rotate` takes the period of a turn, not a speed.
    moves.push_back(fmt::format("fix turn_{0} all move/mesh mesh {0} rotate origin {1} axis {2} period {3}", body.name,
                                vector_text(body.rotation->point), vector_text(unit(body.rotation->axis)),
                                2.0 * kPi / body.rotation->speed));
  }
  return render(templates::stock_walls, "stock_walls.tmpl",
                {{"meshes", fmt::format("{}", fmt::join(meshes, "\n"))},
                 {"rolling", rolling_style(c)},
                 {"n_meshes", std::to_string(all.size())},
                 {"mesh_names", fmt::format("{}", fmt::join(names, " "))},
                 {"moves", fmt::format("{}", fmt::join(moves, "\n"))}});
}

}  // namespace

Result<std::string> wall_commands(const DemCase& c, const std::vector<Body>& all) {
  return c.walls == Walls::granary ? own_walls(c, all) : stock_walls(c, all);
}

std::string watching_walls(const DemCase& c, const std::vector<Body>& all) {
  if (c.walls == Walls::granary) return {};
  return fmt::format(
      "\n\n# Push nobody: they see where the others do. LIGGGHTS' own lose a touch now and then, and begin it anew.\n"
      "fix watch all granary/wall type 2 push no{}{}\n",
      rolling_style(c), own_bodies(all));
}

std::string resize_walls(const DemCase& c, const std::vector<Body>& all) {
  if (c.walls == Walls::granary) return " walls walls";
  std::string meshes;
  for (const Body& body : all) meshes += " mesh " + body.name;
  return meshes;
}

// A particle that slides along the shell touches facet after facet of its polygon: so many glancing touches, the more
// the finer the mesh, are no impacts. Those that break granules are the rotors'.
std::string tally_bodies(const DemCase& c, const std::vector<Body>& all) {
  std::string bodies;
  for (const Body& body : all)
    if (turns(body) || nothing_turns(all))
      bodies += fmt::format(" &\n          body {} of {}", body.name, c.walls == Walls::granary ? "walls" : "watch");
  return bodies;
}

std::string rolling_style(const DemCase& c) {
  return c.contact.rolling_friction > 0.0 ? " rolling_friction epsd2" : "";
}

}  // namespace granary::dem
