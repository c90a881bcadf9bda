// estimation: which settings of the PBM are fitted to which data, in which experiments.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "common/json/io.hpp"
#include "common/json/reader.hpp"
#include "common/units.hpp"
#include "controller/campaign/campaign_schema.hpp"
#include "controller/campaign/estimation_targets.hpp"
#include "controller/campaign/overrides.hpp"
#include "controller/campaign/pointer.hpp"
#include "controller/campaign/reread.hpp"
#include "controller/campaign/sections.hpp"

namespace granary::campaign {
namespace {

using json::Range;
using Efficiency = pbm::Efficiency::Model;

/// A setting of the workflow that can be fitted.
struct Fittable {
  const char* key;    ///< in the workflow
  const char* place;  ///< in case.json
  const char* unit;   ///< "rate": that of the kernel or the selection
  Range range;
  const char* where = "";  ///< where it has an effect: "stokes", "impact, ..."; "": wherever its section is
};

const std::vector<Fittable>& fittables() {
  static const std::vector<Fittable> all{
      {"/pbm/aggregation/rate", "/aggregation/rate", "rate", Range::not_negative()},
      {"/pbm/aggregation/efficiency/value", "/aggregation/efficiency/value", "1", Range::fraction(), "constant, wet"},
      {"/pbm/aggregation/efficiency/least_liquid_fraction", "/aggregation/efficiency/least_liquid_fraction", "1",
       Range::fraction(), "wet"},
      {"/pbm/aggregation/efficiency/restitution",
       "/aggregation/efficiency/restitution",
       "1",
       {0.0, 1.0, false, true},
       "stokes"},
      {"/pbm/aggregation/efficiency/asperity", "/aggregation/efficiency/asperity", "m", Range::positive(), "stokes"},
      {"/pbm/breakage/rate", "/breakage/rate", "rate", Range::not_negative()},
      {"/pbm/breakage/critical_stokes_deformation", "/breakage/critical_stokes_deformation", "1", Range::positive(),
       "impact"},
      {"/pbm/breakage/exponent", "/breakage/exponent", "1", Range::between(0.0, 10.0), "power"},
      {"/pbm/breakage/primary_diameter", "/breakage/primary_diameter", "m", Range::positive(), "impact"},
      {"/pbm/consolidation/rate", "/consolidation/rate", "1/s", Range::not_negative()},
      {"/pbm/consolidation/least_porosity", "/consolidation/least_porosity", "1", {0.0, 1.0, true, false}},
      {"/materials/liquid/viscosity", "/materials/liquid_viscosity", "Pa s", Range::positive()},
      {"/materials/liquid/saturation_factor", "/materials/saturation_factor", "1", Range::fraction()},
  };
  return all;
}

std::string fittable_keys() {
  std::string keys;
  for (const Fittable& one : fittables()) keys += (keys.empty() ? "" : ", ") + std::string(one.key);
  return keys;
}

std::string unit_in(const Fittable& setting, const pbm::PbmCase& balance) {
  if (std::string_view(setting.unit) != "rate") return setting.unit;
  if (std::string_view(setting.key).find("aggregation") == std::string_view::npos)
    return balance.breakage && (balance.breakage->selection == pbm::Breakage::Selection::impact ||
                                balance.breakage->selection == pbm::Breakage::Selection::table)
               ? "1"
               : "1/s";
  using Kernel = pbm::Aggregation::Kernel;
  const Kernel kernel = balance.aggregation ? balance.aggregation->kernel : Kernel::dem;
  return kernel == Kernel::dem || kernel == Kernel::table ? "1" : kernel == Kernel::shear ? "1/s" : "m^3/s";
}

/// Which of the models that `where` speaks of the campaign has.
std::string model_of(const Fittable& setting, const json::Value& balance) {
  const bool sticking = std::string_view(setting.key).find("efficiency") != std::string_view::npos;
  return sticking ? balance["aggregation"]["efficiency"].text_or("model", "")
                  : balance["breakage"].text_or("selection", "");
}

/// The setting a key names, with its present value; the problem goes to `key` of the reader where there is none.
struct Setting {
  const Fittable* is = nullptr;
  std::string unit;
  double value = 0.0;
};

std::optional<Setting> find_setting(json::Reader& reader, const std::string& at, const std::string& key,
                                    const pbm::PbmCase& balance) {
  const auto is =
      std::find_if(fittables().begin(), fittables().end(), [&](const Fittable& one) { return one.key == key; });
  if (is == fittables().end()) {
    std::vector<std::string> keys;
    for (const Fittable& one : fittables()) keys.emplace_back(one.key);
    const std::string near = json::did_you_mean(key, keys);
    reader.problem(at, "this is no setting that can be fitted.",
                   near.empty() ? "It must be one of: " + fittable_keys() + "." : "Did you mean " + near + "?");
    return std::nullopt;
  }
  const json::Value document = pbm::to_json(balance);
  const json::Value* value = find(document, is->place);
  if (value == nullptr) {
    reader.problem(at, "what it belongs to is not modelled.",
                   fmt::format("Add {} to the workflow.", std::string(key).substr(0, key.rfind('/'))));
    return std::nullopt;
  }
  if (const std::string model = model_of(*is, document);
      *is->where != '\0' && (", " + std::string(is->where) + ",").find(", " + model + ",") == std::string::npos) {
    reader.problem(at, fmt::format("it has no effect with the model \"{}\".", model),
                   fmt::format("It belongs to: {}.", is->where));
    return std::nullopt;
  }
  return Setting{&*is, unit_in(*is, balance), value->as_number()};
}

/// A number where the setting has no unit, else a text with one.
double read_value(json::Reader& reader, const char* key, const Setting& of, Range range) {
  return of.unit == "1" ? reader.number(key, range) : reader.quantity(key, of.unit, range);
}

std::optional<estimation::Prior> read_prior(json::Reader& parameter, const Setting& of, bool log) {
  auto reader = parameter.optional_section("prior");
  if (!reader) return std::nullopt;
  estimation::Prior prior;
  prior.mean = read_value(*reader, "mean", of, of.is->range);
  if (log) {
    if (!(prior.mean > 0.0)) reader->problem("mean", "on a log scale it must be > 0.");
    prior.deviation = std::log10(reader->number("factor", Range{1.0, 1e30, false, true}));
    if (reader->has("deviation"))
      reader->problem("deviation", "on a log scale the width of a prior is a factor.", R"(For example "factor": 3.)");
  } else {
    prior.deviation = read_value(*reader, "deviation", of, Range::positive());
    if (reader->has("factor"))
      reader->problem("factor", "on a linear scale the width of a prior is a deviation.", "Or set the scale to log.");
  }
  reader->done();
  return prior;
}

/// Names are for tables and files: anything printable will do, but only once.
std::string read_name(json::Reader& reader, std::set<std::string>& names) {
  const std::string name = reader.text("name");
  const bool printable = std::none_of(name.begin(), name.end(), [](unsigned char c) { return c < ' ' || c == 127; });
  if (name.empty() ? reader.has("name") : !printable || name.size() > 60)
    reader.problem("name", "it must be 1 to 60 printable characters.");
  else if (!name.empty() && !names.insert(name).second)
    reader.problem("name", "there is another one of that name.", "Give each its own.");
  return name;
}

void read_parameter(json::Reader& reader, const pbm::PbmCase& balance, Estimation& estimation,
                    std::set<std::string>& names, std::set<std::string>& keys) {
  estimation::Parameter is;
  is.name = read_name(reader, names);
  const std::string key = reader.text("key");
  const bool log = reader.choice_or("scale", "log", {"linear", "log"}) == "log";
  is.scale = log ? estimation::Scale::log : estimation::Scale::linear;
  const auto setting = key.empty() ? std::nullopt : find_setting(reader, "key", key, balance);
  if (!setting) {
    for (const char* other : {"from", "to", "prior"}) reader.raw(other);  // their kind depends on the setting
    return reader.done();
  }
  if (!keys.insert(key).second) reader.problem("key", "another parameter has this key.");
  is.pointer = setting->is->place;
  is.start = setting->value;
  is.low = read_value(reader, "from", *setting, setting->is->range);
  is.high = read_value(reader, "to", *setting, setting->is->range);
  is.prior = read_prior(reader, *setting, log);
  if (log && reader.has("from") && !(is.low > 0.0))
    reader.problem("from", "on a log scale it must be > 0.", R"(Or set "scale": "linear".)");
  if (reader.has("from") && reader.has("to") && !(is.high > is.low))
    reader.problem("to", "it must be larger than \"from\".");
  else if (*is.start < is.low || *is.start > is.high)
    reader.problem("key",
                   fmt::format("the workflow's own value, {:g}, where the search begins, is not between {:g} and {:g}.",
                               *is.start, is.low, is.high),
                   "Widen the bounds, or change " + key + ".");
  reader.done();
  estimation.parameters.push_back({key, setting->unit, std::move(is)});
}

void read_fixed(json::Reader& reader, const pbm::PbmCase& balance, Estimation& estimation,
                const std::set<std::string>& fitted) {
  for (const std::string& key : reader.texts_or("fixed", {})) {
    if (fitted.count(key) != 0) {
      reader.problem("fixed", "\"" + key + "\" is fitted.", "Take it out of the one list or the other.");
    } else if (const auto setting = find_setting(reader, "fixed", key, balance)) {
      estimation.fixed.push_back({key, setting->unit, setting->value});
    }
  }
}

/// Rates of an earlier campaign: what one of its PBM bursts ran with (bursts/NNNN-pbm/case.json).
std::optional<pbm::DemRates> read_rates(json::Reader& reader, const Campaign& campaign) {
  const std::string name = reader.text_or("rates", "");
  if (name.empty()) return std::nullopt;
  const auto document = json::read_file(campaign.folder / name);
  const auto balance = document ? pbm::read_case(*document, name) : Result<pbm::PbmCase>(document.error());
  const std::string hint = "It must be the case.json of a PBM burst of an earlier campaign.";
  if (!balance)
    reader.problem("rates", without_folder(balance.error().message, campaign.folder), hint);
  else if (!balance->dem)
    reader.problem("rates", "this case has no rates of a DEM.", hint);
  else if (balance->compartments.count != campaign.pbm_case.compartments.count)
    reader.problem("rates", fmt::format("they are of {} compartments, and the workflow has {}.",
                                        balance->compartments.count, campaign.pbm_case.compartments.count));
  else
    return balance->dem;
  return std::nullopt;
}

/// The workflow without its estimation and with other settings, understood anew.
std::optional<pbm::PbmCase> read_set(json::Reader& reader, const json::Value& set, const Campaign& campaign,
                                     bool own_rates, const std::set<std::string>& fitted) {
  if (!set.is_object()) {
    reader.problem("set", "it must be an object of settings.", R"(For example {"/spray/liquid_to_solid": 0.35}.)");
    return std::nullopt;
  }
  json::Value document = campaign.document;
  auto& members = document.members();
  members.erase(
      std::remove_if(members.begin(), members.end(), [](const auto& one) { return one.first == "estimation"; }),
      members.end());
  json::Problems problems;
  for (const auto& [key, value] : set.members()) {
    if (fitted.count(key) != 0)
      reader.problem("set", "\"" + key + "\" is fitted.", "It is the same in every experiment.");
    const bool dem = is_within(key, "/dem") || is_within(key, "/machine") || is_within(key, "/materials/contact");
    if (dem && own_rates)
      reader.problem("set", "\"" + key + "\" changes what the DEM measures.",
                     "Give the \"rates\" of a campaign that ran with it.");
    if (const auto hint = unknown_setting(workflow_schema(), key))
      problems.add({campaign.file.string(), key, "", "no such setting.", *hint});
    else if (!set_value(document, key, value))
      problems.add(
          {campaign.file.string(), key, "", "the workflow has no such place in a list.", "Set the whole list."});
  }
  const auto understood = reread_campaign(std::move(document), campaign.file, campaign.folder);
  if (understood && problems.empty()) return understood->pbm_case;
  const std::string others = understood ? "" : "\n" + understood.error().message;
  const std::string unknown = problems.empty() ? "" : "\n" + problems.error().message;
  reader.problem("set", "with it the workflow has problems:" + unknown + others);
  return std::nullopt;
}

void read_experiments(json::Reader& reader, const Campaign& campaign, Estimation& estimation, bool rest_is_sound,
                      const std::set<std::string>& fitted) {
  std::set<std::string> names;
  for (json::Reader& item : reader.items("experiments")) {
    Estimation::Experiment experiment{read_name(item, names), campaign.pbm_case, read_rates(item, campaign)};
    const bool own_rates = !experiment.rates && campaign.coupling.mode != CouplingSettings::Mode::pbm_only;
    if (const json::Value* set = item.raw("set"); set != nullptr && rest_is_sound)
      if (auto balance = read_set(item, *set, campaign, own_rates, fitted)) experiment.balance = std::move(*balance);
    item.done();
    estimation.experiments.push_back(std::move(experiment));
  }
  if (reader.has("experiments") && reader.raw("experiments")->is_array() && estimation.experiments.empty())
    reader.problem("experiments", "there is none.", "Leave it out: then it is the workflow itself.");
  if (estimation.experiments.empty()) estimation.experiments.push_back({"workflow", campaign.pbm_case, std::nullopt});
}

}  // namespace

void read_estimation(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  const bool rest_is_sound = problems.empty();
  auto reader = root.optional_section("estimation");
  if (!reader) return;
  Estimation estimation;
  std::set<std::string> names, keys;
  for (json::Reader& item : reader->items("parameters"))
    read_parameter(item, campaign.pbm_case, estimation, names, keys);
  if (names.empty())
    reader->problem("parameters", "there is none.",
                    R"(Add for example {"name": "rate", "key": "/pbm/aggregation/rate", "from": 1e-4, "to": 1}.)");
  read_fixed(*reader, campaign.pbm_case, estimation, keys);
  read_experiments(*reader, campaign, estimation, rest_is_sound, keys);
  read_targets(*reader, campaign, estimation);
  const std::vector<std::string> methods{"hybrid", "cma-es", "differential-evolution", "ensemble-kalman",
                                         "least-squares"};  // as estimation::name_of() has them
  estimation.method = reader->choice_or("method", estimation.method, methods);
  estimation.seed = reader->integer_or("seed", estimation.seed, Range::between(0, 2147483647));
  const std::string adopt = reader->choice_or("adopt", "end", {"never", "end", "continuously"});
  estimation.adopt = adopt == "never" ? Estimation::Adopt::never
                     : adopt == "end" ? Estimation::Adopt::end
                                      : Estimation::Adopt::continuously;
  estimation.most_evaluations =
      reader->integer_or("most_evaluations", estimation.most_evaluations, Range::between(10, 10'000'000));
  reader->done();
  campaign.estimation = std::move(estimation);
}

}  // namespace granary::campaign
