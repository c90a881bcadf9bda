#include "estimation/problem/parameter.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "common/assert.hpp"

namespace granary::estimation {
namespace {

/// The value at a pointer; its steps are keys of objects or indices of arrays. nullptr: nothing there.
template <class AnyValue>
AnyValue* at(AnyValue& document, std::string_view pointer) {
  AnyValue* here = &document;
  while (!pointer.empty() && here != nullptr) {
    if (pointer.front() != '/') return nullptr;
    pointer.remove_prefix(1);
    const std::string step(pointer.substr(0, pointer.find('/')));
    pointer.remove_prefix(step.size());
    if (here->is_array()) {
      char* end = nullptr;
      const unsigned long index = std::strtoul(step.c_str(), &end, 10);
      here = *end == '\0' && !step.empty() && index < here->size() ? &here->items()[index] : nullptr;
    } else {
      here = here->find(step);
    }
  }
  return here;
}

double on_scale(double value, Scale scale) { return scale == Scale::log ? std::log(value) : value; }

}  // namespace

double Parameter::place_of(double value) const {
  const double from = on_scale(low, scale), to = on_scale(high, scale);
  return std::clamp((on_scale(value, scale) - from) / (to - from), 0.0, 1.0);
}

double Parameter::value_at(double place) const {
  const double from = on_scale(low, scale), to = on_scale(high, scale), x = from + place * (to - from);
  return std::clamp(scale == Scale::log ? std::exp(x) : x, low, high);
}

std::vector<double> values_at(const std::vector<Parameter>& parameters, const std::vector<double>& point) {
  std::vector<double> values;
  for (std::size_t k = 0; k < parameters.size(); ++k) values.push_back(parameters[k].value_at(point[k]));
  return values;
}

std::vector<double> places_of(const std::vector<Parameter>& parameters, const std::vector<double>& values) {
  std::vector<double> places;
  for (std::size_t k = 0; k < parameters.size(); ++k) places.push_back(parameters[k].place_of(values[k]));
  return places;
}

json::Value with_parameters(json::Value pbm_case, const std::vector<Parameter>& parameters,
                            const std::vector<double>& values) {
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    json::Value* place = at(pbm_case, parameters[k].pointer);
    GRANARY_ASSERT(place != nullptr, parameters[k].pointer);
    if (place != nullptr) *place = values[k];
  }
  return pbm_case;
}

std::optional<double> number_at(const json::Value& pbm_case, const std::string& pointer) {
  const json::Value* place = at(pbm_case, pointer);
  return place != nullptr && place->is_number() ? std::optional(place->as_number()) : std::nullopt;
}

json::Value to_json(const Parameter& p) {
  json::Value document = json::Value::object({{"name", p.name},
                                              {"pointer", p.pointer},
                                              {"low", p.low},
                                              {"high", p.high},
                                              {"scale", p.scale == Scale::log ? "log" : "linear"}});
  if (p.prior) document.set("prior", json::Value::object({{"mean", p.prior->mean}, {"deviation", p.prior->deviation}}));
  if (p.start) document.set("start", *p.start);
  return document;
}

}  // namespace granary::estimation
