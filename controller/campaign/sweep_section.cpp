// sweep: which solver, which settings, and the values they take in each case.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "common/json/reader.hpp"
#include "controller/campaign/campaign_schema.hpp"
#include "controller/campaign/overrides.hpp"
#include "controller/campaign/pointer.hpp"
#include "controller/campaign/sections.hpp"

namespace granary::campaign {
namespace {

constexpr std::size_t kMostCases = 100000;

/// What a case is made of; the rest of a workflow belongs to the sweep as a whole.
bool is_of_a_case(const std::string& pointer) {
  const auto steps = steps_of(pointer);
  static const std::set<std::string> sections{"materials", "machine", "feed", "charge",      "process",
                                              "spray",     "dem",     "pbm",  "agglomerates"};
  return !steps.empty() && sections.count(steps.front()) == 1;
}

/// Why no case can have this setting; nothing if it can.
std::optional<std::pair<std::string, std::string>> problem_of(const std::string& pointer) {
  if (pointer.empty() || pointer[0] != '/')
    return std::pair{"it must be a pointer to a setting.", "Such as \"/machine/impeller_speed\"."};
  if (const auto hint = unknown_setting(workflow_schema(), pointer)) return std::pair{"no such setting.", *hint};
  if (!is_of_a_case(pointer))
    return std::pair{
        "it belongs to the sweep as a whole, not to its cases.",
        "Cases may differ in materials, machine, feed, charge, process, spray, dem, pbm and agglomerates."};
  return std::nullopt;
}

/// The place of a setting among the columns, made if it is new.
std::size_t column_of(Sweep& sweep, const std::string& pointer) {
  const auto same = [&](const Sweep::Setting& setting) { return setting.pointer == pointer; };
  const auto found = std::find_if(sweep.settings.begin(), sweep.settings.end(), same);
  if (found == sweep.settings.end()) {
    const auto steps = steps_of(pointer);
    sweep.settings.push_back({pointer, steps.back()});
    return sweep.settings.size() - 1;
  }
  return static_cast<std::size_t>(found - sweep.settings.begin());
}

struct Axis {
  std::size_t column;
  json::Array values;
  std::string place;  ///< of the values
};

std::vector<Axis> read_axes(json::Reader& reader, Sweep& sweep) {
  std::vector<Axis> axes;
  for (json::Reader& item : reader.items("grid")) {
    const std::string pointer = item.text("setting");
    const std::string name = item.text_or("name", "");
    const json::Value* values = item.raw("values");
    const auto wrong = problem_of(pointer);
    const auto taken = std::any_of(sweep.settings.begin(), sweep.settings.end(),
                                   [&](const Sweep::Setting& setting) { return setting.pointer == pointer; });
    if (item.has("setting") && wrong) item.problem("setting", wrong->first, wrong->second);
    if (taken) item.problem("setting", "it is in the grid twice.", "Give all its values in one place.");
    if (values == nullptr || !values->is_array() || values->size() == 0)
      item.problem("values", "it must be a list of the values that the setting takes, at least one.");
    else if (!wrong && !taken) {
      axes.push_back({column_of(sweep, pointer), values->items(), item.pointer("values")});
      if (!name.empty()) sweep.settings[axes.back().column].name = name;
    }
    item.done();
  }
  return axes;
}

/// Every combination; the last setting changes fastest.
void add_grid(const std::vector<Axis>& axes, Sweep& sweep, json::Reader& reader) {
  if (axes.empty()) return;
  std::size_t n = 1;
  for (const Axis& axis : axes) n = std::min(kMostCases + 1, n * axis.values.size());
  if (n > kMostCases)
    return reader.problem("grid", fmt::format("it makes more than {} cases.", kMostCases), "Give fewer values.");
  for (std::size_t i = 0; i < n; ++i) {
    SweepCase one;
    one.values.resize(sweep.settings.size());
    one.places.resize(sweep.settings.size());
    std::size_t rest = i;
    for (auto axis = axes.rbegin(); axis != axes.rend(); ++axis) {
      const std::size_t at = rest % axis->values.size();
      one.values[axis->column] = axis->values[at];
      one.places[axis->column] = with_step(axis->place, std::to_string(at));
      rest /= axis->values.size();
    }
    sweep.cases.push_back(std::move(one));
  }
}

void add_list(json::Reader& reader, Sweep& sweep, json::Problems& problems) {
  const json::Value* list = reader.raw("cases");
  if (list == nullptr) return;
  if (!list->is_array() || list->size() == 0)
    return reader.problem("cases", "it must be a list of cases, each with the settings it changes.",
                          R"(Such as [{"/machine/impeller_speed": "300 rpm"}].)");
  for (std::size_t i = 0; i < list->size(); ++i) {
    const json::Value& item = list->items()[i];
    const std::string place = with_step(reader.pointer("cases"), std::to_string(i));
    SweepCase one;
    if (!item.is_object() || item.size() == 0) {
      problems.add({reader.file(), place, "", "a case must name at least one setting and its value.",
                    R"(Such as {"/machine/impeller_speed": "300 rpm"}.)"});
      continue;
    }
    for (const auto& [pointer, value] : item.members()) {
      if (const auto wrong = problem_of(pointer)) {
        problems.add({reader.file(), with_step(place, pointer), "", wrong->first, wrong->second});
        continue;
      }
      const std::size_t column = column_of(sweep, pointer);
      one.values.resize(std::max(one.values.size(), column + 1));
      one.values[column] = value;
      one.places.resize(one.values.size());
      one.places[column] = with_step(place, pointer);
    }
    sweep.cases.push_back(std::move(one));
  }
}

/// Each case as often with another seed, one after the other.
void repeat_cases(int repeats, json::Reader& reader, json::Reader& root, Sweep& sweep) {
  if (repeats == 1) return;
  if (sweep.solver == Sweep::Solver::pbm)
    return reader.problem("repeats", "a population balance comes out the same each time.", "Remove it.");
  const std::size_t n_settings = sweep.settings.size(), seeds = column_of(sweep, kSeedSetting);
  if (seeds < n_settings)
    return reader.problem("repeats", std::string(kSeedSetting) + " is swept already.", "Give one of both.");
  const json::Value* dem = root.raw("dem");
  const json::Value* given = dem != nullptr && dem->is_object() ? dem->find("seed") : nullptr;
  const std::int64_t first = given != nullptr && given->is_integer() ? given->as_integer() : dem::DemCase{}.seed;
  std::vector<SweepCase> repeated;
  for (const SweepCase& one : sweep.cases)
    for (std::int64_t k = 0; k < repeats; ++k) {
      constexpr std::int64_t kApart = 1000003, kRoom = kLargestSeed - 1000;
      repeated.push_back(one);
      repeated.back().values.resize(seeds + 1);
      repeated.back().places.resize(seeds + 1);
      repeated.back().values[seeds] = k == 0 ? first : next_seed((first + k * kApart) % kRoom);
      repeated.back().places[seeds] = reader.pointer("repeats");
    }
  sweep.cases = std::move(repeated);
  if (sweep.cases.size() > kMostCases)
    reader.problem("repeats", fmt::format("it makes more than {} cases.", kMostCases), "Give fewer.");
}

/// Two columns of one name could not be told apart: then they are called by their pointers.
void make_names_distinct(Sweep& sweep) {
  std::map<std::string, int> uses;
  for (const Sweep::Setting& setting : sweep.settings) ++uses[setting.name];
  for (Sweep::Setting& setting : sweep.settings)
    if (uses[setting.name] > 1) setting.name = setting.pointer;
}

}  // namespace

void read_sweep(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  Sweep& sweep = campaign.sweep;
  if (!root.has("sweep")) {
    root.problem(
        "sweep", "it is missing and must be given.",
        R"(Add for example "sweep": {"solver": "pbm", "grid": [{"setting": "/pbm/bins", "values": [16, 32]}]}.)");
    return;
  }
  json::Reader reader = root.section("sweep");
  sweep.solver = reader.choice("solver", {"dem", "pbm"}) == "dem" ? Sweep::Solver::dem : Sweep::Solver::pbm;
  const auto axes = read_axes(reader, sweep);
  add_grid(axes, sweep, reader);
  add_list(reader, sweep, problems);
  repeat_cases(static_cast<int>(reader.integer_or("repeats", 1, json::Range::between(1, 1000))), reader, root, sweep);
  if (!reader.has("grid") && !reader.has("cases"))
    reader.problem("grid", "there is nothing to sweep: neither a grid nor a list of cases.",
                   R"(Add for example "grid": [{"setting": "/pbm/bins", "values": [16, 32]}].)");
  else if (sweep.cases.empty() && problems.empty())
    reader.problem("grid", "it makes no case.", "Give at least one setting with one value.");
  if (reader.has("reference")) {
    sweep.reference = campaign.folder / reader.text("reference");
    if (!std::filesystem::is_regular_file(*sweep.reference))
      reader.problem("reference", "there is no file " + sweep.reference->string() + ".",
                     "Its path begins at the workflow's folder.");
  }
  reader.done();
  make_names_distinct(sweep);
  for (std::size_t i = 0; i < sweep.cases.size(); ++i) {
    sweep.cases[i].name = fmt::format("{:04}", i + 1);
    sweep.cases[i].values.resize(sweep.settings.size());
    sweep.cases[i].places.resize(sweep.settings.size());
  }
}

}  // namespace granary::campaign
