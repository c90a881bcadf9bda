#include "dem_templates/render/deck.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "common/units.hpp"
#include "dem_templates/geometry/stl.hpp"
#include "dem_templates/render/automatic.hpp"
#include "dem_templates/render/regions.hpp"
#include "dem_templates/render/render.hpp"
#include "dem_templates/render/time_step.hpp"
#include "dem_templates/render/wall_commands.hpp"
#include "dem_templates/templates.hpp"

namespace granary::dem {
namespace {

namespace fs = std::filesystem;

constexpr long kGuardEvery = 50;   // steps between the guard's looks
constexpr long kThermoLines = 20;  // of a burst's log

std::string number(long n) { return fmt::format("{}", n); }

std::string_view axis_name(Axis axis) { return axis == Axis::x ? "x" : axis == Axis::y ? "y" : "z"; }

long particles_of(const DemCase& c) {
  long sum = 0;
  for (const Population& p : c.population)
    for (long n : p.count) sum += n;
  return sum;
}

double mass_of(const DemCase& c) {
  double sum = 0.0;
  for (const Population& p : c.population)
    for (std::size_t i = 0; i < p.diameter.size(); ++i)
      sum += static_cast<double>(p.count[i]) * c.density * kPi / 6.0 * std::pow(p.diameter[i], 3);
  return sum + c.feed_rate * (c.settle_time + c.duration);
}

// Kinetic energy beyond which a burst has diverged: energy_factor times that of all at tip speed and fallen through the
// machine.
double energy_bound(const DemCase& c, const Box3& box) {
  const double tip = tip_speed(c.machine), fall = std::abs(dot(gravity_direction(c.machine), box.high - box.low));
  return c.guard.energy_factor * mass_of(c) * (0.5 * tip * tip + kGravity * fall);
}

std::string rank_grid(const DemCase& c) {
  const auto grid = c.rank_grid[0] > 0 ? c.rank_grid : automatic_rank_grid(c);
  return fmt::format("{} {} {}", grid[0], grid[1], grid[2]);
}

Result<std::string> state_commands(const DemCase& c, const Box3& box) {
  if (c.restart) return render(templates::restart, "restart.tmpl", {{"restart", c.restart->string()}});
  return render(templates::empty, "empty.tmpl",
                {{"xlo", digits(box.low.x)},
                 {"xhi", digits(box.high.x)},
                 {"ylo", digits(box.low.y)},
                 {"yhi", digits(box.high.y)},
                 {"zlo", digits(box.low.z)},
                 {"zhi", digits(box.high.z)}});
}

Result<std::string> material_commands(const Contact& m) {
  GRANARY_TRY(std::string text, render(templates::materials, "materials.tmpl",
                                       {{"young_modulus", digits(m.young_modulus)},
                                        {"wall_young_modulus", digits(m.wall_young_modulus)},
                                        {"poisson_ratio", digits(m.poisson_ratio)},
                                        {"restitution", digits(m.restitution)},
                                        {"friction", digits(m.friction)}}));
  if (m.rolling_friction > 0.0) {
    GRANARY_TRY(const std::string rolling,
                render(templates::rolling, "rolling.tmpl", {{"rolling_friction", digits(m.rolling_friction)}}));
    text += rolling;
  }
  return text;
}

Result<std::string> fill_commands(const DemCase& c, const std::vector<Body>& all) {
  if (c.restart) return std::string();  // they are in it
  const Agglomerates& a = *c.agglomerates;
  return render(templates::fill_agglomerates, "fill_agglomerates.tmpl",
                {{"spheres", number(a.spheres)},
                 {"sphere_diameter", digits(a.sphere_diameter)},
                 {"diameter", digits(a.diameter)},
                 {"count", number(a.count)},
                 {"density", digits(c.density)},
                 {"resize_walls", resize_walls(c, all)},
                 {"seed", number(c.seed)},
                 {"settle_steps", number(schedule_of(c).settle)}});
}

// What only a deck of agglomerates has.
Values agglomerate_values(const DemCase& c, std::string fill) {
  const Agglomerates& a = *c.agglomerates;
  const Bonds& b = a.bonds;
  const Schedule schedule = schedule_of(c);
  return {{"normal_stiffness", digits(b.normal_stiffness)},
          {"shear_stiffness", digits(b.shear_stiffness_ratio * b.normal_stiffness)},
          {"tensile_strength", digits(b.tensile_strength)},
          {"shear_strength", digits(b.shear_strength_ratio * b.tensile_strength)},
          {"scatter", b.strength_scatter > 0.0 ? fmt::format(" normal {}", b.strength_scatter) : ""},
          {"radius_scale", digits(b.radius)},
          {"gap", digits(b.gap * 0.5 * a.sphere_diameter)},
          {"damping", digits(b.damping)},
          {"sample_every", number(schedule.sample)},
          {"state_every", number(std::max(schedule.window, schedule.sample))},
          {"fill", std::move(fill)},
          {"goes_on", c.restart ? " goes_on yes" : ""},
          {"last_step", number(schedule.settle + schedule.steps)}};
}

// What only a deck of single particles has.
Values population_values(const DemCase& c, const std::vector<Body>& all) {
  const Schedule schedule = schedule_of(c);
  return {{"resize_walls", resize_walls(c, all)},
          {"settle_steps", number(schedule.settle)},
          {"steps", number(schedule.steps)}};
}

Result<std::string> run_commands(const DemCase& c, const std::vector<Body>& all) {
  const Schedule schedule = schedule_of(c);
  std::vector<double> edges{c.population.front().from};
  for (const Population& p : c.population) edges.push_back(p.to);
  Values values{{"space", space_commands(c.machine)},
                {"guard_every", number(kGuardEvery)},
                {"overlap", digits(c.guard.largest_overlap)},
                {"overlapping", digits(c.guard.overlapping_fraction)},
                {"energy", digits(energy_bound(c, simulation_box(all)))},
                {"lost", digits(c.guard.lost_fraction)},
                {"thermo", number(std::max(1L, (schedule.settle + schedule.steps) / kThermoLines))},
                {"axis", std::string(axis_name(axis_of(c.machine)))},
                {"seed", number(c.seed)},
                {"skin_trial", skin_trial(c)},
                {"every", number(c.tally.every)},
                {"window", number(schedule.window)},
                {"compartments", fmt::format("{} {}", c.population.size(), fmt::join(edges, " "))},
                {"classes", fmt::format("{} {}", c.tally.class_edges.size() - 1, fmt::join(c.tally.class_edges, " "))},
                {"coarse_graining", digits(c.coarse_graining)},
                {"tally_bodies", tally_bodies(c, all)}};
  const auto with = [&values](const Values& more) { values.insert(values.end(), more.begin(), more.end()); };
  if (!c.agglomerates) {
    with(population_values(c, all));
    return render(templates::run, "run.tmpl", values);
  }
  GRANARY_TRY(std::string fill, fill_commands(c, all));
  with(agglomerate_values(c, std::move(fill)));
  return render(templates::run_agglomerates, "run_agglomerates.tmpl", values);
}

// A restart of another machine would be read without complaint: hold its case.json against ours.
Status check_restart(const DemCase& c, const fs::path& folder) {
  if (!c.restart) return {};
  const fs::path file = (folder / *c.restart).lexically_normal();  // an absolute path stays itself
  if (!fs::is_regular_file(file))
    return Error{fmt::format("{}: no such restart file. The burst before writes it at its end and when it is stopped.",
                             file.string())};
  const fs::path before = file.parent_path() / "case.json";
  if (!fs::exists(before)) return {};
  GRANARY_TRY(const json::Value document, json::read_file(before));
  GRANARY_TRY(const DemCase previous, read_case(document, before.string()));
  const auto same_walls = [](Machine m) {
    m.impeller_speed = m.chopper_speed = 0.0;
    DemCase walls;
    walls.machine = m;
    return to_json(walls)["machine"];
  };
  if (previous.walls != c.walls)
    return Error{
        fmt::format("{}: was written with other walls ({}, /walls), which keep the blades' angle in another "
                    "way. Start without a restart, or keep the walls.",
                    file.string(), before.string())};
  if (!(same_walls(previous.machine) == same_walls(c.machine)))
    return Error{fmt::format(
        "{}: is the restart of another case: its machine ({}, /machine) is not this burst's. Start without a restart.",
        file.string(), before.string())};
  return {};
}

}  // namespace

namespace {

/// A whole part of a window, or whole windows.
long sample_steps(const DemCase& c, long window, long samples) {
  const long windows = std::lround(c.agglomerates->sample_every / c.tally.window);
  return windows > 1 ? windows * window : window / samples;
}

}  // namespace

Schedule schedule_of(const DemCase& c) {
  Schedule s;
  s.settle = std::lround(c.settle_time / c.time_step);
  // Windows are whole looks, and of agglomerates whole samples: the state that each leaves is at one.
  const long samples = c.agglomerates ? std::max(1L, std::lround(c.tally.window / c.agglomerates->sample_every)) : 1L;
  const long unit = c.tally.every * samples;
  s.window = std::max(1L, std::lround(c.tally.window / c.time_step / static_cast<double>(unit))) * unit;
  s.sample = c.agglomerates ? sample_steps(c, s.window, samples) : 0;
  s.steps = std::max(1L, std::lround(c.duration / c.time_step / static_cast<double>(s.window))) * s.window;
  return s;
}

// The settled bed is the first that is like all later ones. Stock walls need a longer reach than the particles. Cells
// as wide as the lists reach are fewer to go through than LIGGGHTS' own, half as wide.
std::string skin_trial(const DemCase& c) {
  if (c.skin || c.walls == Walls::stock) return "";
  return fmt::format(
      "\n# The neighbour skin that suits this bed.\n"
      "fix skin all granary/skin speed {}\n"
      "variable skin equal f_skin\n"
      "variable reach equal f_skin[1]\n"
      "neighbor ${{skin}} bin\n"
      "neigh_modify binsize ${{reach}}\n"
      "unfix skin\n",
      tip_speed(c.machine));
}

// A longer reach makes longer lists, a shorter one makes them more often: the best grows as the square root of what the
// blade tips travel in a step, measured on the mixer at 5 and 10 us (docs/dem.md).
double neighbour_skin(const DemCase& c) {
  double largest = 0.0;
  for (const Population& p : c.population)
    for (std::size_t i = 0; i < p.diameter.size(); ++i)
      if (p.count[i] > 0) largest = std::max(largest, p.diameter[i]);
  if (c.skin) return *c.skin;
  if (c.walls == Walls::granary) return 0.6 * largest;
  const double best = 8.5 * std::sqrt(tip_speed(c.machine) * c.time_step * largest);
  return std::clamp(best, 0.25 * largest, 2.0 * largest);
}

Result<std::string> input_script(const DemCase& c, const std::vector<Body>& all) {
  const TimeStepFigures figures = time_step_figures(c);
  GRANARY_TRY(const std::string state, state_commands(c, simulation_box(all)));
  GRANARY_TRY(const std::string materials, material_commands(c.contact));
  GRANARY_TRY(const std::string walls, wall_commands(c, all));
  GRANARY_TRY(const std::string run, run_commands(c, all));
  Values values{
      {"name", c.name},
      {"particles", number(particles_of(c))},
      {"tip_speed", fmt::format("{:.4g}", figures.impact_speed)},
      {"time_step_comment", fmt::format("time step {:.1f} % of the Rayleigh time, 1/{:.0f} of the contact time.",
                                        100 * figures.rayleigh_share, 1 / figures.contact_share)},
      {"state", state},
      {"skin", digits(neighbour_skin(c))},
      {"rank_grid", rank_grid(c)},
      {"materials", materials},
      {"rolling", rolling_style(c)},
      {"time_step", digits(c.time_step)},
      {"gravity", digits(kGravity)},
      {"walls", walls + watching_walls(c, all)},
      {"run", run}};
  if (c.machine.type == Machine::Type::batch_bowl)
    return render(templates::in_batch_bowl, "in.batch_bowl.tmpl", values);
  std::string outlet, feed;
  if (c.machine.mixer.outlet_open) {
    GRANARY_TRY(outlet, outlet_commands(c.machine.mixer));
  }
  if (c.feed_rate > 0.0) {
    GRANARY_TRY(feed, feed_commands(c));
  }
  values.insert(values.end(), {{"outlet", outlet}, {"feed", feed}});
  return render(templates::in_cm5, "in.cm5.tmpl", values);
}

json::Value population_json(const DemCase& c) {
  json::Value compartments = json::Value::array();
  for (const Population& p : c.population) {
    json::Value counts = json::Value::array();
    for (long n : p.count) counts.push(json::Value(static_cast<std::int64_t>(n)));
    compartments.push(
        json::Value::object({{"from_m", p.from}, {"to_m", p.to}, {"diameters_m", p.diameter}, {"counts", counts}}));
  }
  return json::Value::object({{"format", "granary-population-1"},
                              {"density_kg_m3", c.density},
                              {"coarse_graining", c.coarse_graining},
                              {"compartments", compartments}});
}

Status write_burst(const DemCase& asked, const fs::path& folder) {
  // The same checks whether the case came from a file or from the controller.
  GRANARY_TRY(const DemCase c, read_case(to_json(asked), (folder / "case.json").string()));
  GRANARY_CHECK(check_restart(c, folder));
  GRANARY_TRY(const std::vector<Body> all, bodies(c.machine));
  GRANARY_TRY(const std::string input, input_script(c, all));
  GRANARY_CHECK(make_folders(folder / "meshes"));
  for (const Body& body : all)
    GRANARY_CHECK(write_text_atomically(folder / "meshes" / (body.name + ".stl"), stl_text(body.mesh, body.name)));
  GRANARY_CHECK(json::write_file(folder / "population.json", population_json(c)));
  GRANARY_CHECK(json::write_file(folder / "case.json", to_json(c)));
  return write_text_atomically(folder / "in.liggghts", input);
}

}  // namespace granary::dem
