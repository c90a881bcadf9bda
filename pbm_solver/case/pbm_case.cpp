#include "pbm_solver/case/pbm_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/json/reader.hpp"

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

const std::vector<std::string> kEfficiencies{"constant", "wet", "stokes"};
const std::vector<std::string> kKernels{"constant", "sum", "product", "shear", "dem", "table"};
const std::vector<std::string> kLookups{"size", "group"};
const std::vector<std::string> kMethods{"automatic", "pairs", "low_rank"};
const std::vector<std::string> kSelections{"constant", "linear", "power", "impact", "table"};
const std::vector<std::string> kDaughters{"uniform_binary", "halves", "same_composition", "table"};

/// The enumerator whose name was read: the names are listed in the order of the enumerators.
template <class Enum>
Enum chosen(Reader& reader, const std::string& key, Enum otherwise, const std::vector<std::string>& names) {
  const std::string name = reader.choice_or(key, names[static_cast<std::size_t>(otherwise)], names);
  return static_cast<Enum>(std::find(names.begin(), names.end(), name) - names.begin());
}

template <class Enum>
std::string name_of(Enum value, const std::vector<std::string>& names) {
  return names[static_cast<std::size_t>(value)];
}

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

SpeedDistribution read_speeds(std::optional<Reader> reader) {
  SpeedDistribution speeds;
  if (!reader) return speeds;
  speeds.ln_mean = reader->number_or("ln_mean", speeds.ln_mean);
  speeds.ln_sigma = reader->number_or("ln_sigma", speeds.ln_sigma, Range::positive());
  reader->done();
  return speeds;
}

/// C_pq: square, as wide as there are classes, not negative, symmetric.
std::vector<std::vector<double>> read_pair_rates(Reader& reader, const std::string& key, std::size_t n_classes) {
  const Value* rows = reader.raw(key);
  if (rows == nullptr) return {};
  const auto is_row = [&](const Value& row) {
    return row.is_array() && row.size() == n_classes &&
           std::all_of(row.items().begin(), row.items().end(),
                       [](const Value& c) { return c.is_number() && Range::not_negative().contains(c.as_number()); });
  };
  if (!rows->is_array() || rows->size() != n_classes ||
      !std::all_of(rows->items().begin(), rows->items().end(), is_row)) {
    reader.problem(
        key, fmt::format("it must have {0} rows of {0} numbers >= 0, one for each pair of size classes.", n_classes));
    return {};
  }
  std::vector<std::vector<double>> rate;
  for (const Value& row : rows->items()) rate.push_back(row.numbers());
  for (std::size_t p = 0; p < n_classes; ++p)
    for (std::size_t q = 0; q < p; ++q)
      if (std::abs(rate[p][q] - rate[q][p]) > 1e-9 * std::max(rate[p][q], rate[q][p]))
        reader.problem(key, fmt::format("it must be symmetric, but [{0}][{1}] and [{1}][{0}] differ.", p, q));
  return rate;
}

std::vector<double> read_class_centres(Reader& reader) {
  std::vector<double> diameter = reader.numbers("diameter", Range::positive());
  if (diameter.empty()) reader.problem("diameter", "it must have at least one size class.");
  if (std::adjacent_find(diameter.begin(), diameter.end(), std::greater_equal<>()) != diameter.end())
    reader.problem("diameter", "the class centres must rise.");
  return diameter;
}

DemRates read_dem(Reader reader, const Compartments& row) {
  DemRates dem;
  dem.diameter = read_class_centres(reader);
  const std::size_t n_classes = dem.diameter.size();
  dem.collision_rate = read_pair_rates(reader, "collision_rate", n_classes);
  if (reader.has("compartment_factor")) {
    dem.compartment_factor = reader.numbers("compartment_factor", Range::not_negative());
    if (dem.compartment_factor.size() != static_cast<std::size_t>(row.count))
      reader.problem("compartment_factor",
                     fmt::format("it must have {} numbers, one for each compartment.", row.count));
  }
  if (reader.has("impact_rate")) {
    dem.impact_rate = reader.numbers("impact_rate", Range::not_negative());
    if (dem.impact_rate.size() != n_classes)
      reader.problem("impact_rate", fmt::format("it must have {} numbers, one for each size class.", n_classes));
  }
  dem.collision_speed = read_speeds(reader.optional_section("collision_speed"));
  dem.impact_speed = read_speeds(reader.optional_section("impact_speed"));
  reader.done();
  return dem;
}

Efficiency read_efficiency(Reader reader, bool has_dem) {
  Efficiency e;
  e.model = chosen(reader, "model", e.model, kEfficiencies);
  e.value = reader.number_or("value", e.value, Range::fraction());
  e.least_liquid_fraction = reader.number_or("least_liquid_fraction", e.least_liquid_fraction, Range::fraction());
  e.restitution = reader.number_or("restitution", e.restitution, Range{0.0, 1.0, false, true});
  e.asperity = reader.number_or("asperity", e.asperity, Range::positive());
  if (e.model == Efficiency::Model::stokes && !has_dem)
    reader.problem("model", "it needs collision speeds.", "Give the section /dem.");
  reader.done();
  return e;
}

KernelTable read_kernel_table(Reader reader) {
  KernelTable table;
  table.diameter = read_class_centres(reader);
  table.rate = read_pair_rates(reader, "rate", table.diameter.size());
  reader.done();
  return table;
}

Aggregation read_aggregation(Reader reader, const std::optional<DemRates>& dem) {
  Aggregation a;
  a.kernel = chosen(reader, "kernel", a.kernel, kKernels);
  a.rate = reader.number_or("rate", a.rate, Range::not_negative());
  if (auto section = reader.optional_section("efficiency")) a.efficiency = read_efficiency(*section, dem.has_value());
  if (a.kernel == Aggregation::Kernel::dem && !dem)
    reader.problem("kernel", "it needs collision rates.", "Give the section /dem.");
  a.lookup = chosen(reader, "lookup", a.lookup, kLookups);
  a.method = chosen(reader, "method", a.method, kMethods);
  if (auto section = reader.optional_section("table")) a.table = read_kernel_table(*section);
  if (a.kernel == Aggregation::Kernel::table && a.table.diameter.empty())
    reader.problem("kernel", "it needs rates between diameters.", "Give the section /aggregation/table.");
  if (a.kernel == Aggregation::Kernel::dem && dem && dem->collision_rate.empty())
    reader.problem("kernel", "it needs collision rates.", "Give /dem/collision_rate.");
  reader.done();
  return a;
}

/// "daughters" of a table: for each parent a list of [share, number].
std::vector<std::vector<BreakageTable::Daughter>> read_daughters(Reader& reader, std::size_t n_parents) {
  std::vector<std::vector<BreakageTable::Daughter>> all;
  const Value* written = reader.raw("daughters");
  if (written == nullptr || !written->is_array() || written->size() != n_parents) {
    reader.problem("daughters", fmt::format("it must be {} lists of [share, number], one for each solid.", n_parents));
    return {};
  }
  for (std::size_t p = 0; p < n_parents; ++p) {
    std::vector<BreakageTable::Daughter> of_one;
    double volume = 0.0;
    for (const Value& item : written->items()[p].items_or_none()) {
      const auto pair = item.numbers();
      if (pair.size() != 2 || !(pair[0] > 0.0) || !(pair[0] < 1.0) || !(pair[1] >= 0.0) || !std::isfinite(pair[1])) {
        reader.problem("daughters",
                       fmt::format("list {} has an item that is no [share in (0, 1), number >= 0].", p + 1));
        return {};
      }
      of_one.push_back({pair[0], pair[1]});
      volume += pair[0] * pair[1];
    }
    if (!of_one.empty() && std::abs(volume - 1.0) > 1e-9) {
      reader.problem("daughters",
                     fmt::format("the shares of list {}, times their numbers, add up to {:.10g}; it must be "
                                 "1: no volume comes or goes.",
                                 p + 1, volume));
      return {};
    }
    all.push_back(std::move(of_one));
  }
  return all;
}

BreakageTable read_table(Reader reader, bool with_daughters) {
  BreakageTable table;
  table.solid = reader.numbers("solid", Range::positive());
  table.rate = reader.numbers("rate", Range::not_negative());
  if (table.solid.empty()) reader.problem("solid", "it is empty.", "Give the solid volume of at least one parent.");
  if (table.rate.size() != table.solid.size())
    reader.problem("rate", fmt::format("it must have {} numbers, one for each solid.", table.solid.size()));
  if (std::adjacent_find(table.solid.begin(), table.solid.end(), std::greater_equal<>()) != table.solid.end())
    reader.problem("solid", "it must ascend.");
  if (with_daughters || reader.has("daughters")) table.daughters = read_daughters(reader, table.solid.size());
  const auto is_empty = [](const auto& list) { return list.empty(); };
  if (with_daughters && std::all_of(table.daughters.begin(), table.daughters.end(), is_empty))
    reader.problem("daughters", "no parent has any.");
  for (std::size_t p = 0; with_daughters && p < table.daughters.size() && p < table.rate.size(); ++p)
    if (table.daughters[p].empty() && table.rate[p] > 0.0)
      reader.problem("daughters", fmt::format("list {} is empty, but that parent breaks.", p + 1));
  reader.done();
  return table;
}

Breakage read_breakage(Reader reader, const std::optional<DemRates>& dem) {
  Breakage b;
  b.selection = chosen(reader, "selection", b.selection, kSelections);
  b.daughters = chosen(reader, "daughters", b.daughters, kDaughters);
  b.rate = reader.number_or("rate", b.rate, Range::not_negative());
  b.exponent = reader.number_or("exponent", b.exponent, Range::between(0.0, 10.0));
  b.critical_stokes_deformation =
      reader.number_or("critical_stokes_deformation", b.critical_stokes_deformation, Range::positive());
  b.primary_diameter = reader.number_or("primary_diameter", b.primary_diameter, Range::positive());
  const bool daughters = b.daughters == Breakage::Daughters::table;
  if (auto table = reader.optional_section("table")) b.table = read_table(std::move(*table), daughters);
  if ((daughters || b.selection == Breakage::Selection::table) && !reader.has("table"))
    reader.problem("table", "it is missing, and selection or daughters are of it.");
  if (b.selection == Breakage::Selection::impact && (!dem || dem->impact_rate.empty()))
    reader.problem("selection", "it needs impact rates.",
                   "Give /dem/impact_rate, or take \"constant\", \"linear\", \"power\" or \"table\".");
  reader.done();
  return b;
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

Value speeds_json(const SpeedDistribution& s) {
  return Value::object({{"ln_mean", s.ln_mean}, {"ln_sigma", s.ln_sigma}});
}

Value pair_json(const std::array<double, 2>& pair) { return Value(json::Array{pair[0], pair[1]}); }

Value feed_json(const Feed& feed) {
  Value classes = Value::array();
  for (const ClassRate& c : feed.classes) classes.push(Value::object({{"i", c.i}, {"j", c.j}, {"rate", c.rate}}));
  return Value::object({{"classes", classes}, {"porosity", feed.porosity}, {"start", feed.start}, {"end", feed.end}});
}

Value dem_json(const DemRates& dem) {
  Value document = Value::object({{"diameter", dem.diameter}});
  if (!dem.collision_rate.empty()) document.set("collision_rate", dem.collision_rate);
  if (!dem.compartment_factor.empty()) document.set("compartment_factor", dem.compartment_factor);
  if (!dem.impact_rate.empty()) document.set("impact_rate", dem.impact_rate);
  document.set("collision_speed", speeds_json(dem.collision_speed));
  document.set("impact_speed", speeds_json(dem.impact_speed));
  return document;
}

Value aggregation_json(const Aggregation& a) {
  const Efficiency& e = a.efficiency;
  Value efficiency = Value::object({{"model", name_of(e.model, kEfficiencies)},
                                    {"value", e.value},
                                    {"least_liquid_fraction", e.least_liquid_fraction},
                                    {"restitution", e.restitution},
                                    {"asperity", e.asperity}});
  Value document = Value::object({{"kernel", name_of(a.kernel, kKernels)},
                                  {"rate", a.rate},
                                  {"lookup", name_of(a.lookup, kLookups)},
                                  {"method", name_of(a.method, kMethods)}});
  if (!a.table.diameter.empty())
    document.set("table", Value::object({{"diameter", a.table.diameter}, {"rate", a.table.rate}}));
  return document.set("efficiency", efficiency);
}

Value breakage_json(const Breakage& b) {
  Value document = Value::object({{"selection", name_of(b.selection, kSelections)},
                                  {"daughters", name_of(b.daughters, kDaughters)},
                                  {"rate", b.rate},
                                  {"exponent", b.exponent},
                                  {"critical_stokes_deformation", b.critical_stokes_deformation},
                                  {"primary_diameter", b.primary_diameter}});
  if (!b.table.solid.empty()) document.set("table", to_json(b.table));
  return document;
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

Result<BreakageTable> read_breakage_table(const json::Value& document, const std::string& file) {
  constexpr const char* kKernelFormat = "granary-breakage-kernel-1";
  if (document.text_or("format", "") != kKernelFormat)
    return Error{
        fmt::format("{}: this is no breakage kernel (its \"format\" is not \"{}\"). granary kernel writes them.", file,
                    kKernelFormat)};
  json::Problems problems;
  Reader reader(document, file, problems);
  BreakageTable table = read_table(reader.section("table"), true);
  if (!problems.empty()) return problems.error();
  return table;
}

json::Value to_json(const BreakageTable& t) {
  Value daughters = Value::array();
  for (const auto& of_one : t.daughters) {
    Value list = Value::array();
    for (const BreakageTable::Daughter& d : of_one) list.push(Value(json::Array{d.share, d.number}));
    daughters.push(std::move(list));
  }
  Value document = Value::object({{"solid", t.solid}, {"rate", t.rate}});
  if (!t.daughters.empty()) document.set("daughters", std::move(daughters));
  return document;
}

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
