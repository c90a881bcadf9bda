#include "dem_templates/case/dem_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/json/reader.hpp"

namespace granary::dem {
namespace {

using json::Range;
using json::Reader;
using json::Value;

constexpr const char* kFormat = "granary-dem-case-1";

// LIGGGHTS refuses what is outside of these (checks of its own, in SI units).
const Range kYoungModulus = Range::at_least(5e6);
const Range kRestitution{0.05, 1.0, false, true};
const Range kPoissonRatio{0.0, 0.5, false, true};

HorizontalMixer read_mixer(Reader in) {
  HorizontalMixer m;
  m.inlet_diameter = in.number_or("inlet_diameter", m.inlet_diameter, Range::positive());
  m.outlet_diameter = in.number_or("outlet_diameter", m.outlet_diameter, Range::positive());
  m.length = in.number_or("length", m.length, Range::positive());
  m.shaft_diameter = in.number_or("shaft_diameter", m.shaft_diameter, Range::positive());
  m.shaft_length = in.number_or("shaft_length", m.shaft_length, Range::positive());
  m.impeller_diameter = in.number_or("impeller_diameter", m.impeller_diameter, Range::positive());
  m.feed_elements = static_cast<int>(in.integer_or("feed_elements", m.feed_elements, Range::between(0, 1000)));
  m.shear_elements = static_cast<int>(in.integer_or("shear_elements", m.shear_elements, Range::between(0, 1000)));
  m.exit_elements = static_cast<int>(in.integer_or("exit_elements", m.exit_elements, Range::between(0, 1000)));
  m.outlet_open = in.boolean_or("outlet_open", m.outlet_open);
  if (m.shaft_length > 0.95 * m.length)
    in.problem("shaft_length", "the outlet lies behind the shaft's end: at most 95 % of length");
  if (m.impeller_diameter >= std::min(m.inlet_diameter, m.outlet_diameter))
    in.problem("impeller_diameter", "must be smaller than the casing at both ends");
  if (m.shaft_diameter >= m.impeller_diameter) in.problem("shaft_diameter", "must be smaller than impeller_diameter");
  if (m.feed_elements + m.shear_elements + m.exit_elements < 1)
    in.problem("shear_elements", "the impeller has no elements");
  in.done();
  return m;
}

Value mixer_json(const HorizontalMixer& m) {
  return Value::object({{"inlet_diameter", m.inlet_diameter},
                        {"outlet_diameter", m.outlet_diameter},
                        {"length", m.length},
                        {"shaft_diameter", m.shaft_diameter},
                        {"shaft_length", m.shaft_length},
                        {"impeller_diameter", m.impeller_diameter},
                        {"feed_elements", m.feed_elements},
                        {"shear_elements", m.shear_elements},
                        {"exit_elements", m.exit_elements},
                        {"outlet_open", m.outlet_open}});
}

BatchBowl read_bowl(Reader in) {
  BatchBowl b;
  b.bottom_diameter = in.number_or("bottom_diameter", b.bottom_diameter, Range::positive());
  b.cylinder_height = in.number_or("cylinder_height", b.cylinder_height, Range::positive());
  b.cover_diameter = in.number_or("cover_diameter", b.cover_diameter, Range::positive());
  b.cover_height = in.number_or("cover_height", b.cover_height, Range::positive());
  b.lid_height = in.number_or("lid_height", b.lid_height, Range::positive());
  b.impeller_diameter = in.number_or("impeller_diameter", b.impeller_diameter, Range::positive());
  b.impeller_blades = static_cast<int>(in.integer_or("impeller_blades", b.impeller_blades, Range::between(1, 12)));
  b.impeller_pitch = in.number_or("impeller_pitch", b.impeller_pitch, Range::between(0.0, 1.3));
  b.impeller_blade_width = in.number_or("impeller_blade_width", b.impeller_blade_width, Range::positive());
  b.chopper_diameter = in.number_or("chopper_diameter", b.chopper_diameter, Range::positive());
  b.chopper_blades = static_cast<int>(in.integer_or("chopper_blades", b.chopper_blades, Range::between(1, 12)));
  b.chopper_clearance = in.number_or("chopper_clearance", b.chopper_clearance, Range::positive());
  b.chopper_position = in.number_or("chopper_position", b.chopper_position, Range::positive());
  if (!(b.cylinder_height < b.cover_height && b.cover_height < b.lid_height))
    in.problem("cover_height", "must lie between cylinder_height and lid_height");
  if (b.impeller_diameter >= b.bottom_diameter) in.problem("impeller_diameter", "must be smaller than bottom_diameter");
  if (b.chopper_diameter > 0.4 * b.bottom_diameter)
    in.problem("chopper_diameter", "must be at most 40 % of bottom_diameter");
  if (b.impeller_blade_width >= 0.5 * b.bottom_diameter)
    in.problem("impeller_blade_width", "must be below half of bottom_diameter");
  if (b.chopper_position >= 0.5 * b.bottom_diameter)
    in.problem("chopper_position", "must lie inside of bottom_diameter");
  in.done();
  return b;
}

Value bowl_json(const BatchBowl& b) {
  return Value::object({{"bottom_diameter", b.bottom_diameter},
                        {"cylinder_height", b.cylinder_height},
                        {"cover_diameter", b.cover_diameter},
                        {"cover_height", b.cover_height},
                        {"lid_height", b.lid_height},
                        {"impeller_diameter", b.impeller_diameter},
                        {"impeller_blades", b.impeller_blades},
                        {"impeller_pitch", b.impeller_pitch},
                        {"impeller_blade_width", b.impeller_blade_width},
                        {"chopper_diameter", b.chopper_diameter},
                        {"chopper_blades", b.chopper_blades},
                        {"chopper_clearance", b.chopper_clearance},
                        {"chopper_position", b.chopper_position}});
}

std::optional<std::filesystem::path> read_path(Reader& in, const std::string& key) {
  if (!in.has(key)) return std::nullopt;
  return std::filesystem::path(in.text(key));
}

Machine read_machine(Reader in) {
  Machine m;
  m.type = in.choice_or("type", "cm5", {"cm5", "batch_bowl"}) == "cm5" ? Machine::Type::cm5 : Machine::Type::batch_bowl;
  if (auto mixer = in.optional_section("mixer")) m.mixer = read_mixer(std::move(*mixer));
  if (auto bowl = in.optional_section("bowl")) m.bowl = read_bowl(std::move(*bowl));
  m.impeller_speed = in.number_or("impeller_speed", m.impeller_speed);
  m.chopper_speed = in.number_or("chopper_speed", m.chopper_speed);
  m.shell_stl = read_path(in, "shell_stl");
  m.impeller_stl = read_path(in, "impeller_stl");
  m.refinement = static_cast<int>(in.integer_or("refinement", m.refinement, Range::between(1, 20)));
  in.done();
  return m;
}

Value machine_json(const Machine& m) {
  Value out = Value::object({{"type", m.type == Machine::Type::cm5 ? "cm5" : "batch_bowl"},
                             {"mixer", mixer_json(m.mixer)},
                             {"bowl", bowl_json(m.bowl)},
                             {"impeller_speed", m.impeller_speed},
                             {"chopper_speed", m.chopper_speed},
                             {"refinement", m.refinement}});
  if (m.shell_stl) out.set("shell_stl", m.shell_stl->string());
  if (m.impeller_stl) out.set("impeller_stl", m.impeller_stl->string());
  return out;
}

Contact read_contact(Reader in) {
  Contact c;
  c.young_modulus = in.number_or("young_modulus", c.young_modulus, kYoungModulus);
  c.wall_young_modulus = in.number_or("wall_young_modulus", c.wall_young_modulus, kYoungModulus);
  c.poisson_ratio = in.number_or("poisson_ratio", c.poisson_ratio, kPoissonRatio);
  c.restitution = in.number_or("restitution", c.restitution, kRestitution);
  c.friction = in.number_or("friction", c.friction, Range::not_negative());
  c.rolling_friction = in.number_or("rolling_friction", c.rolling_friction, Range::not_negative());
  in.done();
  return c;
}

Value contact_json(const Contact& c) {
  return Value::object({{"young_modulus", c.young_modulus},
                        {"wall_young_modulus", c.wall_young_modulus},
                        {"poisson_ratio", c.poisson_ratio},
                        {"restitution", c.restitution},
                        {"friction", c.friction},
                        {"rolling_friction", c.rolling_friction}});
}

Population read_compartment(Reader in) {
  Population p;
  p.from = in.number("from");
  p.to = in.number("to");
  p.diameter = in.numbers("diameter", Range::positive());
  for (double n : in.numbers("count", Range::not_negative())) {
    if (n != std::floor(n)) in.problem("count", "must be whole numbers of particles");
    p.count.push_back(static_cast<long>(n));
  }
  if (p.diameter.size() != p.count.size())
    in.problem("count", fmt::format("has {} numbers for {} diameters; each diameter needs its own", p.count.size(),
                                    p.diameter.size()));
  if (!(p.from < p.to)) in.problem("to", "must be larger than from");
  in.done();
  return p;
}

Value compartment_json(const Population& p) {
  Value counts = Value::array();
  for (long n : p.count) counts.push(Value(static_cast<std::int64_t>(n)));
  return Value::object({{"from", p.from}, {"to", p.to}, {"diameter", p.diameter}, {"count", counts}});
}

Tally read_tally(Reader in) {
  Tally t;
  t.window = in.number_or("window", t.window, Range::positive());
  t.every = static_cast<int>(in.integer_or("every", t.every, Range::between(1, 1e6)));
  t.class_edges = in.numbers("class_edges", Range::not_negative());
  if (t.class_edges.size() < 2) in.problem("class_edges", "needs at least two diameters, the ends of the only class");
  if (std::adjacent_find(t.class_edges.begin(), t.class_edges.end(), std::greater_equal<>()) != t.class_edges.end())
    in.problem("class_edges", "must ascend");
  in.done();
  return t;
}

Guard read_guard(Reader in) {
  Guard g;
  g.largest_overlap = in.number_or("largest_overlap", g.largest_overlap, Range::positive());
  g.overlapping_fraction = in.number_or("overlapping_fraction", g.overlapping_fraction, Range::fraction());
  g.energy_factor = in.number_or("energy_factor", g.energy_factor, Range::positive());
  g.lost_fraction = in.number_or("lost_fraction", g.lost_fraction, Range::fraction());
  in.done();
  return g;
}

void check_population(Reader& in, const DemCase& c) {
  long particles = 0;
  for (const Population& p : c.population)
    for (long n : p.count) particles += n;
  if (particles == 0)
    in.problem("population", "holds no particles: a DEM burst needs at least one",
               "Lower the coarse graining, or fill the machine more.");
  for (std::size_t i = 1; i < c.population.size(); ++i)
    if (std::abs(c.population[i].from - c.population[i - 1].to) > 1e-9)
      in.problem("population", fmt::format("compartment {} begins at {} m, but the one before ends at {} m; they must "
                                           "follow each other along the axis",
                                           i + 1, c.population[i].from, c.population[i - 1].to));
}

void read_rank_grid(Reader& in, DemCase& c) {
  if (!in.has("rank_grid")) return;
  const auto grid = in.numbers("rank_grid", Range::at_least(1));
  double product = 1.0;
  for (std::size_t d = 0; d < std::min<std::size_t>(grid.size(), 3); ++d) {
    c.rank_grid[d] = static_cast<int>(grid[d]);
    product *= c.rank_grid[d];
  }
  if (grid.size() != 3 || product != c.ranks)
    in.problem("rank_grid", fmt::format("must be three whole numbers whose product is the {} of ranks", c.ranks));
}

}  // namespace

Result<DemCase> read_case(const json::Value& document, const std::string& file) {
  json::Problems problems;
  Reader in(document, file, problems);
  DemCase c;
  in.choice("format", {kFormat});
  c.name = in.text_or("name", "");
  if (auto machine = in.optional_section("machine")) c.machine = read_machine(std::move(*machine));
  c.walls = in.choice_or("walls", "granary", {"granary", "stock"}) == "granary" ? Walls::granary : Walls::stock;
  if (auto contact = in.optional_section("contact")) c.contact = read_contact(std::move(*contact));
  c.density = in.number_or("density", c.density, Range::positive());
  c.coarse_graining = in.number_or("coarse_graining", c.coarse_graining, Range::positive());
  for (Reader& item : in.items("population")) c.population.push_back(read_compartment(std::move(item)));
  check_population(in, c);
  if (auto agglomerates = in.optional_section("agglomerates"))
    c.agglomerates = read_agglomerates(std::move(*agglomerates), Written::in_si);
  c.feed_rate = in.number_or("feed_rate", c.feed_rate, Range::not_negative());
  c.feed_diameter = in.number_or("feed_diameter", c.feed_diameter, Range::not_negative());
  if (c.feed_rate > 0.0 && c.machine.type == Machine::Type::batch_bowl)
    in.problem("feed_rate", "a batch bowl is not fed: it must be 0");
  c.time_step = in.number_or("time_step", c.time_step, Range::positive());
  c.impact_speed = in.number_or("impact_speed", c.impact_speed, Range::not_negative());
  if (in.has("skin")) c.skin = in.number("skin", Range::positive());
  c.settle_time = in.number_or("settle_time", c.settle_time, Range::not_negative());
  c.duration = in.number_or("duration", c.duration, Range::positive());
  c.tally = read_tally(in.section("tally"));
  if (auto guard = in.optional_section("guard")) c.guard = read_guard(std::move(*guard));
  c.restart = read_path(in, "restart");
  c.seed = static_cast<long>(in.integer_or("seed", c.seed, Range::between(1, 2147483647)));
  c.ranks = static_cast<int>(in.integer_or("ranks", c.ranks, Range::at_least(1)));
  read_rank_grid(in, c);
  in.done();
  if (!problems.empty()) return problems.error();
  return c;
}

json::Value to_json(const DemCase& c) {
  Value population = Value::array();
  for (const Population& p : c.population) population.push(compartment_json(p));
  Value out = Value::object(
      {{"format", kFormat},
       {"name", c.name},
       {"machine", machine_json(c.machine)},
       {"walls", c.walls == Walls::granary ? "granary" : "stock"},
       {"contact", contact_json(c.contact)},
       {"density", c.density},
       {"coarse_graining", c.coarse_graining},
       {"population", population},
       {"feed_rate", c.feed_rate},
       {"feed_diameter", c.feed_diameter},
       {"time_step", c.time_step},
       {"impact_speed", c.impact_speed},
       {"settle_time", c.settle_time},
       {"duration", c.duration},
       {"tally",
        Value::object({{"window", c.tally.window}, {"every", c.tally.every}, {"class_edges", c.tally.class_edges}})},
       {"guard", Value::object({{"largest_overlap", c.guard.largest_overlap},
                                {"overlapping_fraction", c.guard.overlapping_fraction},
                                {"energy_factor", c.guard.energy_factor},
                                {"lost_fraction", c.guard.lost_fraction}})}});
  if (c.agglomerates) out.set("agglomerates", to_json(*c.agglomerates));
  if (c.restart) out.set("restart", c.restart->string());
  out.set("seed", static_cast<std::int64_t>(c.seed));
  out.set("ranks", c.ranks);
  if (c.skin) out.set("skin", *c.skin);
  if (c.rank_grid[0] > 0)
    out.set("rank_grid", Value::array().push(c.rank_grid[0]).push(c.rank_grid[1]).push(c.rank_grid[2]));
  return out;
}

}  // namespace granary::dem
