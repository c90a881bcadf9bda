#include "pbm_solver/case/pbm_case.hpp"

#include <fmt/format.h>

#include <cmath>

#include "pbm_solver/case/kernel_sections.hpp"

namespace granary::pbm {
namespace {

using json::Range;
using json::Reader;
using json::Value;

constexpr const char* kFormat = "granary-pbm-case-1";
constexpr int kMostBins = 256;
constexpr double kLeastVolume = 1e-100;   // [m^3]: products and quotients of volumes stay normal numbers
constexpr double kLeastRatio = 1.000001;  // neighbouring pivots differ by far more than round-off
constexpr int kMostCompartments = 1024;

/// One number for each of the two solids.
std::array<double, 2> pair_or(Reader& reader, const std::string& key, std::array<double, 2> otherwise, Range range) {
  if (!reader.has(key)) return otherwise;
  const std::vector<double> values = reader.numbers(key, range);
  if (values.size() == 2) return {values[0], values[1]};
  reader.problem(key, fmt::format("it must have 2 numbers{}, one for each solid.", range.clause()));
  return otherwise;
}

Grid read_grid(Reader reader) {
  Grid grid;
  const Grid usual;
  const Range bins{1.0, kMostBins, true, true};
  const auto counts = pair_or(reader, "bins", {double(usual.bins[0]), double(usual.bins[1])}, bins);
  grid.smallest = pair_or(reader, "smallest", usual.smallest, Range::not_negative());
  grid.ratio = pair_or(reader, "ratio", usual.ratio, Range{1.0, 1e6, false, true});
  for (int k = 0; k < 2; ++k) {
    grid.bins[k] = static_cast<int>(counts[k]);
    if (grid.bins[k] != counts[k]) reader.problem("bins", "it must be two whole numbers.");
    if (grid.smallest[k] == 0.0 && grid.bins[k] != 1)
      reader.problem("smallest", "it must be > 0, or 0 for a solid that is absent.", "An absent solid has 1 bin.");
    if (grid.smallest[k] > 0.0 && grid.smallest[k] < kLeastVolume)
      reader.problem("smallest", fmt::format("it must be at least {:g} m^3.", kLeastVolume));
    if (grid.ratio[k] < kLeastRatio)
      reader.problem("ratio", fmt::format("its classes cannot be told apart; it must be at least {}.", kLeastRatio));
    if (!std::isfinite(grid.smallest[k] * std::pow(grid.ratio[k], grid.bins[k] - 1)))
      reader.problem("ratio", "the largest class is beyond all numbers; take fewer bins or a smaller ratio.");
  }
  if (grid.smallest[0] == 0.0 && grid.smallest[1] == 0.0)
    reader.problem("smallest", "at least one solid must be there (> 0).");
  reader.done();
  return grid;
}

Compartments read_compartments(Reader reader) {
  Compartments row;
  row.count = static_cast<int>(reader.integer_or("count", 1, Range::between(1, kMostCompartments)));
  if (reader.has("volume")) row.volume = reader.numbers("volume", Range::positive());
  if (row.volume.empty()) row.volume.assign(static_cast<std::size_t>(row.count), 1.0);
  if (row.volume.size() != static_cast<std::size_t>(row.count))
    reader.problem("volume", fmt::format("it must have {} numbers, one for each compartment.", row.count));
  if (reader.has("residence_time")) row.residence_time = reader.number("residence_time", Range::positive());
  reader.done();
  return row;
}

Materials read_materials(Reader reader) {
  Materials m;
  m.solid_density = pair_or(reader, "solid_density", m.solid_density, Range::positive());
  m.liquid_density = reader.number_or("liquid_density", m.liquid_density, Range::positive());
  m.liquid_viscosity = reader.number_or("liquid_viscosity", m.liquid_viscosity, Range::positive());
  m.saturation_factor = reader.number_or("saturation_factor", m.saturation_factor, Range::not_negative());
  reader.done();
  return m;
}

/// Class indices i and j of an item, held against the grid.
void read_class(Reader& item, const Grid& grid, int& i, int& j) {
  i = static_cast<int>(item.integer("i", Range::between(0, grid.bins[0] - 1)));
  j = static_cast<int>(item.integer("j", Range::between(0, grid.bins[1] - 1)));
}

Feed read_feed(Reader reader, const Grid& grid) {
  Feed feed;
  for (Reader& item : reader.items("classes")) {
    ClassRate& one = feed.classes.emplace_back();
    read_class(item, grid, one.i, one.j);
    one.rate = item.number("rate", Range::not_negative());
    item.done();
  }
  if (feed.classes.empty())
    reader.problem("classes", "a feed needs at least one class.", "Leave the feed out for a batch.");
  feed.porosity = reader.number_or("porosity", feed.porosity, Range{0.0, 1.0, true, false});
  feed.start = reader.number_or("start", feed.start);
  feed.end = reader.number_or("end", feed.end);
  if (!(feed.end > feed.start))
    reader.problem("end", fmt::format("it must be after the feed's start at {:g} s.", feed.start));
  reader.done();
  return feed;
}

Spray read_spray(Reader reader, const Compartments& row) {
  Spray spray;
  spray.rate = reader.number("rate", Range::not_negative());
  spray.compartment = static_cast<int>(reader.integer_or("compartment", 0, Range::between(0, row.count - 1)));
  spray.start = reader.number_or("start", spray.start);
  spray.end = reader.number_or("end", spray.end);
  if (!(spray.end > spray.start))
    reader.problem("end", fmt::format("it must be after the spray's start at {:g} s.", spray.start));
  reader.done();
  return spray;
}

Consolidation read_consolidation(Reader reader) {
  Consolidation c;
  c.rate = reader.number("rate", Range::not_negative());
  c.least_porosity = reader.number_or("least_porosity", c.least_porosity, Range{0.0, 1.0, true, false});
  reader.done();
  return c;
}

InitialClass read_initial_class(Reader& item, const PbmCase& pbm_case) {
  InitialClass one;
  one.compartment =
      static_cast<int>(item.integer_or("compartment", -1, Range::between(-1, pbm_case.compartments.count - 1)));
  read_class(item, pbm_case.grid, one.i, one.j);
  one.number = item.number("number", Range::positive());
  one.liquid = item.number_or("liquid", 0.0, Range::not_negative());
  one.gas = item.number_or("gas", 0.0, Range::not_negative());
  item.done();
  return one;
}

Restart read_restart(Reader reader) {
  Restart restart;
  restart.file = reader.text("file");
  if (restart.file.empty()) reader.problem("file", "it must name the out.h5 or checkpoint.h5 of an earlier run.");
  if (reader.has("time")) restart.time = reader.number("time");
  reader.done();
  return restart;
}

void read_times(Reader& reader, PbmCase& c) {
  c.start_time = reader.number_or("start_time", c.start_time);
  c.end_time = reader.number("end_time");
  const double from = c.restart && c.restart->time ? *c.restart->time : c.start_time;
  if (!(c.end_time > from)) reader.problem("end_time", fmt::format("it must be after the start at {:g} s.", from));
  c.output_every = reader.number_or("output_every", c.output_every, Range::positive());
  c.relative_tolerance = reader.number_or("relative_tolerance", c.relative_tolerance, Range{1e-12, 0.1, true, true});
  c.kernel_tolerance = reader.number_or("kernel_tolerance", c.kernel_tolerance, Range{0.0, 0.1, true, true});
  c.reference_volume = reader.number_or("reference_volume", c.reference_volume, Range::positive());
}

Value pair_json(const std::array<double, 2>& pair) { return Value(json::Array{pair[0], pair[1]}); }

Value feed_json(const Feed& feed) {
  Value classes = Value::array();
  for (const ClassRate& c : feed.classes) classes.push(Value::object({{"i", c.i}, {"j", c.j}, {"rate", c.rate}}));
  return Value::object({{"classes", classes}, {"porosity", feed.porosity}, {"start", feed.start}, {"end", feed.end}});
}

Value initial_json(const std::vector<InitialClass>& initial) {
  Value list = Value::array();
  for (const InitialClass& c : initial)
    list.push(Value::object({{"compartment", c.compartment},
                             {"i", c.i},
                             {"j", c.j},
                             {"number", c.number},
                             {"liquid", c.liquid},
                             {"gas", c.gas}}));
  return list;
}

}  // namespace

Result<PbmCase> read_case(const Value& document, const std::string& file) {
  json::Problems problems;
  Reader reader(document, file, problems);
  PbmCase c;
  reader.choice("format", {kFormat});
  c.name = reader.text_or("name", "");
  c.grid = read_grid(reader.section("grid"));
  if (auto section = reader.optional_section("compartments")) c.compartments = read_compartments(*section);
  if (c.compartments.volume.empty()) c.compartments.volume.assign(static_cast<std::size_t>(c.compartments.count), 1.0);
  if (auto section = reader.optional_section("materials")) c.materials = read_materials(*section);
  if (auto section = reader.optional_section("feed")) c.feed = read_feed(*section, c.grid);
  if (auto section = reader.optional_section("spray")) c.spray = read_spray(*section, c.compartments);
  if (auto section = reader.optional_section("dem")) c.dem = read_dem(*section, c.compartments);
  if (auto section = reader.optional_section("aggregation")) c.aggregation = read_aggregation(*section, c.dem);
  if (auto section = reader.optional_section("breakage")) c.breakage = read_breakage(*section, c.dem);
  if (auto section = reader.optional_section("consolidation")) c.consolidation = read_consolidation(*section);
  if (reader.has("initial"))
    for (Reader& item : reader.items("initial")) c.initial.push_back(read_initial_class(item, c));
  if (auto section = reader.optional_section("restart")) c.restart = read_restart(*section);
  if (c.restart && !c.initial.empty())
    reader.problem("initial", "it cannot stand beside /restart: a run starts from one or the other.");
  read_times(reader, c);
  reader.done();
  if (!problems.empty()) return problems.error();
  return c;
}

Value to_json(const PbmCase& c) {
  Value document = Value::object({{"format", kFormat}, {"name", c.name}});
  document.set("grid", Value::object({{"bins", Value(json::Array{c.grid.bins[0], c.grid.bins[1]})},
                                      {"smallest", pair_json(c.grid.smallest)},
                                      {"ratio", pair_json(c.grid.ratio)}}));
  Value row = Value::object({{"count", c.compartments.count}, {"volume", c.compartments.volume}});
  if (c.compartments.residence_time) row.set("residence_time", *c.compartments.residence_time);
  document.set("compartments", row);
  document.set("materials", Value::object({{"solid_density", pair_json(c.materials.solid_density)},
                                           {"liquid_density", c.materials.liquid_density},
                                           {"liquid_viscosity", c.materials.liquid_viscosity},
                                           {"saturation_factor", c.materials.saturation_factor}}));
  if (c.feed) document.set("feed", feed_json(*c.feed));
  if (c.spray)
    document.set("spray", Value::object({{"rate", c.spray->rate},
                                         {"compartment", c.spray->compartment},
                                         {"start", c.spray->start},
                                         {"end", c.spray->end}}));
  if (c.dem) document.set("dem", dem_json(*c.dem));
  if (c.aggregation) document.set("aggregation", aggregation_json(*c.aggregation));
  if (c.breakage) document.set("breakage", breakage_json(*c.breakage));
  if (c.consolidation)
    document.set("consolidation",
                 Value::object({{"rate", c.consolidation->rate}, {"least_porosity", c.consolidation->least_porosity}}));
  if (!c.initial.empty()) document.set("initial", initial_json(c.initial));
  if (c.restart) {
    Value restart = Value::object({{"file", c.restart->file.string()}});
    if (c.restart->time) restart.set("time", *c.restart->time);
    document.set("restart", restart);
  }
  return document.set("start_time", c.start_time)
      .set("end_time", c.end_time)
      .set("output_every", c.output_every)
      .set("relative_tolerance", c.relative_tolerance)
      .set("kernel_tolerance", c.kernel_tolerance)
      .set("reference_volume", c.reference_volume);
}

}  // namespace granary::pbm
