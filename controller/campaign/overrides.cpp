#include "controller/campaign/overrides.hpp"

#include <algorithm>
#include <cctype>
#include <optional>

#include "common/json/io.hpp"
#include "controller/campaign/pointer.hpp"

namespace granary::campaign {
namespace {

using Nodes = std::vector<const json::Value*>;

/// What a place may be: the schema's node with its references followed and its alternatives side by side.
void expand(const json::Value& schema, const json::Value& node, Nodes& into) {
  if (const json::Value* reference = node.find("$ref"))
    return expand(schema, *find(schema, reference->as_string().substr(1)), into);
  into.push_back(&node);
  for (const char* choice : {"oneOf", "anyOf"})
    if (const json::Value* alternatives = node.find(choice))
      for (const json::Value& alternative : alternatives->items()) expand(schema, alternative, into);
}

Nodes expanded(const json::Value& schema, const Nodes& nodes) {
  Nodes all;
  for (const json::Value* node : nodes) expand(schema, *node, all);
  return all;
}

/// What one step further may be; empty if there is no such setting.
Nodes below(const Nodes& nodes, const std::string& step) {
  Nodes next;
  for (const json::Value* node : nodes) {
    if (const json::Value* known = (*node)["properties"].find(step)) next.push_back(known);
    const json::Value& items = (*node)["items"];
    if (items.is_object() && index_of(step, 1u << 30) >= 0) next.push_back(&items);
    if (items.is_array())
      for (const json::Value& item : items.items()) next.push_back(&item);
    if (const json::Value& any = (*node)["additionalProperties"]; any.is_object()) next.push_back(&any);
  }
  return next;
}

std::vector<std::string> keys(const Nodes& nodes) {
  std::vector<std::string> names;
  for (const json::Value* node : nodes)
    if (const json::Value* properties = node->find("properties"))
      for (const auto& [name, value] : properties->members()) names.push_back(name);
  return names;
}

/// Pointers of all settings whose own name this is: "time_step" -> "/dem/time_step".
void places_named(const json::Value& schema, const Nodes& nodes, const std::string& name, const std::string& at,
                  std::vector<std::string>& places) {
  const Nodes here = expanded(schema, nodes);
  for (const std::string& key : keys(here)) {
    const std::string place = at + "/" + key;
    if (key == name && std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
    places_named(schema, below(here, key), name, place, places);
  }
}

std::string suggestion(const json::Value& schema, const Nodes& here, const std::string& at,
                       const std::vector<std::string>& steps, std::size_t wrong) {
  std::vector<std::string> places;
  places_named(schema, {&schema}, steps.back(), "", places);
  if (places.size() == 1) return "Did you mean " + places.front() + "?";
  const std::string near = json::did_you_mean(steps[wrong], keys(here));
  return near.empty() ? "See docs/workflow_format.md." : "Did you mean " + at + "/" + near + "?";
}

/// The place of the last step, made where the document lacks it; nullptr where a list has no such item, or something
/// single is in the way.
json::Value* place_of(json::Value& document, const std::vector<std::string>& steps) {
  json::Value* at = &document;
  for (const std::string& step : steps) {
    if (at->is_array()) {
      const long index = index_of(step, at->size());
      if (index < 0) return nullptr;
      if (index == static_cast<long>(at->size())) at->push({});
      at = &at->items()[static_cast<std::size_t>(index)];
    } else if (at->is_object() ||
               (at->is_null() && index_of(step, 0) < 0 && !std::isdigit(static_cast<unsigned char>(step[0])))) {
      if (at->find(step) == nullptr) at->set(step, {});
      at = at->find(step);
    } else {
      return nullptr;
    }
  }
  return at;
}

json::Value value_of(const std::string& text) {
  const auto parsed = json::parse(text, "--set");
  return parsed ? *parsed : json::Value(text);
}

}  // namespace

std::optional<std::string> unknown_setting(const json::Value& schema, const std::string& pointer) {
  const auto steps = steps_of(pointer);
  Nodes here = expanded(schema, {&schema});
  std::string at;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Nodes next = below(here, steps[i]);
    if (next.empty()) return suggestion(schema, here, at, steps, i);
    here = expanded(schema, next);
    at += "/" + steps[i];
  }
  return std::nullopt;
}

bool set_value(json::Value& document, const std::string& pointer, json::Value value) {
  json::Value changed = document;  // a place is made on the way there: keep the document as it was if that fails
  json::Value* place = place_of(changed, steps_of(pointer));
  if (place == nullptr) return false;
  *place = std::move(value);
  document = std::move(changed);
  return true;
}

void apply_overrides(json::Value& document, const std::vector<std::string>& overrides, const json::Value& schema,
                     json::Problems& problems) {
  for (const std::string& text : overrides) {
    const std::string name = "--set " + text;
    const std::size_t equals = text.find('=');
    if (text.empty() || text[0] != '/' || equals == std::string::npos) {
      problems.add({name, "", "", "it must be /pointer=value, such as /pbm/bins=32.", ""});
      continue;
    }
    const std::string pointer = text.substr(0, equals);
    if (const auto hint = unknown_setting(schema, pointer))
      problems.add({name, "", "", "no such setting.", *hint});
    else if (!set_value(document, pointer, value_of(text.substr(equals + 1))))
      problems.add({name, "", "", "the workflow has no such place in a list.", "Set the whole list."});
  }
}

}  // namespace granary::campaign
