#include "pbm_solver/case/kernel_sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace granary::pbm {
namespace {

using json::Range;
using json::Reader;
using json::Value;

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

Value speeds_json(const SpeedDistribution& s) {
  return Value::object({{"ln_mean", s.ln_mean}, {"ln_sigma", s.ln_sigma}});
}

}  // namespace

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

}  // namespace granary::pbm
