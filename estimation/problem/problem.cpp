#include "estimation/problem/problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "common/json/reader.hpp"

namespace granary::estimation {
namespace {

using json::Range;
using json::Reader;
using json::Value;

constexpr const char* kFormat = "granary-estimation-1";

Prior read_prior(Reader reader, Scale scale) {
  Prior prior;
  prior.mean = reader.number("mean", scale == Scale::log ? Range::positive() : Range::any());
  prior.deviation = reader.number("deviation", Range::positive());
  reader.done();
  return prior;
}

Parameter read_parameter(Reader& reader) {
  Parameter p;
  p.name = reader.text("name");
  p.pointer = reader.text("pointer");
  p.scale = reader.choice_or("scale", "linear", {"linear", "log"}) == "log" ? Scale::log : Scale::linear;
  p.low = reader.number("low", p.scale == Scale::log ? Range::positive() : Range::any());
  p.high = reader.number("high");
  if (!(p.high > p.low)) reader.problem("high", fmt::format("it must be greater than \"low\", {:g}.", p.low));
  if (auto section = reader.optional_section("prior")) p.prior = read_prior(*section, p.scale);
  if (reader.has("start")) p.start = reader.number("start", Range::between(p.low, p.high));
  reader.done();
  return p;
}

int read_compartment(Reader& reader) {
  const Value* written = reader.raw("compartment");
  if (written == nullptr) return kEverywhere;
  if (written->is_integer() && written->as_integer() >= 0) return static_cast<int>(written->as_integer());
  if (written->is_string() && written->as_string() == "all") return kEverywhere;
  if (written->is_string() && written->as_string() == "outlet") return kOutlet;
  reader.problem("compartment", "it must be an index from 0, \"all\" or \"outlet\".");
  return kEverywhere;
}

void read_distribution(Reader& reader, Target& t) {
  t.edges = reader.numbers("edges", Range::not_negative());
  t.shares = reader.numbers("shares", Range::fraction());
  if (t.edges.size() != t.shares.size() + 1 || t.shares.empty())
    reader.problem("shares", fmt::format("{} edges enclose {} classes, but there are {} shares.", t.edges.size(),
                                         std::max<std::size_t>(t.edges.size(), 1) - 1, t.shares.size()));
  if (std::adjacent_find(t.edges.begin(), t.edges.end(), std::greater_equal<>()) != t.edges.end())
    reader.problem("edges", "the diameters must rise.");
}

Target read_target(Reader& reader) {
  Target t;
  std::vector<std::string> names;
  for (const Quantity q : kQuantities) names.emplace_back(name_of(q));
  t.experiment = reader.text("experiment");
  const auto it = std::find(names.begin(), names.end(), reader.choice("quantity", names));
  if (it != names.end()) t.quantity = kQuantities[it - names.begin()];
  t.time = reader.number("time");
  t.compartment = read_compartment(reader);
  if (t.quantity == Quantity::distribution)
    read_distribution(reader, t);
  else
    t.value = reader.number("value");
  t.error = reader.number("error", Range::positive());
  t.weight = reader.number_or("weight", 1.0, Range::not_negative());
  t.held_out = reader.boolean_or("held_out", false);
  reader.done();
  return t;
}

/// All segments must have a number where each parameter goes.
void check_places(Reader& item, const Experiment& e, const std::vector<Parameter>& parameters) {
  for (std::size_t s = 0; s < e.segments.size(); ++s)
    for (const Parameter& p : parameters)
      if (!number_at(e.segments[s], p.pointer))
        item.problem("segments",
                     fmt::format("segment {} has no number at {}, where parameter \"{}\" goes.", s, p.pointer, p.name));
}

Experiment read_experiment(Reader& reader, const std::vector<Parameter>& parameters) {
  Experiment e;
  e.name = reader.text("name");
  if (const Value* segments = reader.raw("segments"); segments != nullptr && segments->is_array())
    e.segments = segments->items();
  if (e.segments.empty()) reader.problem("segments", "it must be a list of at least one case.");
  check_places(reader, e, parameters);
  reader.done();
  return e;
}

double prior_residual(const Parameter& p, double value) {
  const double away = p.scale == Scale::log ? std::log10(value / p.prior->mean) : value - p.prior->mean;
  return away / p.prior->deviation;
}

}  // namespace

Result<Problem> read_problem(const Value& document, const std::string& file) {
  json::Problems problems;
  Reader reader(document, file, problems);
  Problem p;
  reader.choice("format", {kFormat});
  for (Reader& item : reader.items("parameters")) p.parameters.push_back(read_parameter(item));
  if (p.parameters.empty()) reader.problem("parameters", "there is nothing to estimate: give at least one.");
  std::set<std::string> names;
  for (Reader& item : reader.items("experiments")) {
    p.experiments.push_back(read_experiment(item, p.parameters));
    if (!names.insert(p.experiments.back().name).second) item.problem("name", "another experiment has that name.");
  }
  bool fitted = false;
  for (Reader& item : reader.items("targets")) {
    p.targets.push_back(read_target(item));
    fitted |= !p.targets.back().held_out;
    if (names.count(p.targets.back().experiment) == 0)
      item.problem("experiment", "there is no experiment of that name.");
  }
  if (!fitted) reader.problem("targets", "there is nothing to fit to: give at least one that is not held out.");
  reader.done();
  if (!problems.empty()) return problems.error();
  return p;
}

Value to_json(const Problem& p) {
  Value parameters = Value::array(), experiments = Value::array(), targets = Value::array();
  for (const Parameter& one : p.parameters) parameters.push(to_json(one));
  for (const Experiment& e : p.experiments)
    experiments.push(Value::object({{"name", e.name}, {"segments", Value(e.segments)}}));
  for (const Target& t : p.targets) targets.push(to_json(t));
  return Value::object(
      {{"format", kFormat}, {"parameters", parameters}, {"targets", targets}, {"experiments", experiments}});
}

std::vector<double> start_of(const Problem& problem) {
  std::vector<double> start;
  for (const Parameter& p : problem.parameters) start.push_back(p.start ? p.place_of(*p.start) : 0.5);
  return start;
}

Fit fit_of(const Problem& problem, const std::vector<double>& model, const std::vector<double>& values) {
  Fit fit;
  auto computed = model.begin();
  for (const Target& t : problem.targets) {
    auto& list = t.held_out ? fit.held_out : fit.residuals;
    for (std::size_t k = 0; k < t.size(); ++k) {
      const double measured = t.quantity == Quantity::distribution ? t.shares[k] : t.value;
      list.push_back((*computed++ - measured) / t.error * std::sqrt(t.weight));
    }
  }
  for (std::size_t k = 0; k < values.size(); ++k)
    if (problem.parameters[k].prior) fit.residuals.push_back(prior_residual(problem.parameters[k], values[k]));
  return fit;
}

}  // namespace granary::estimation
