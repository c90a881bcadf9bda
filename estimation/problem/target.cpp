#include "estimation/problem/target.hpp"

namespace granary::estimation {

const char* name_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::d10:
      return "d10";
    case Quantity::d50:
      return "d50";
    case Quantity::d90:
      return "d90";
    case Quantity::number:
      return "number";
    case Quantity::porosity:
      return "porosity";
    case Quantity::liquid_content:
      return "liquid_content";
    case Quantity::solid_mass:
      return "solid_mass";
    case Quantity::distribution:
      return "distribution";
  }
  return "";
}

const char* unit_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::d10:
    case Quantity::d50:
    case Quantity::d90:
      return "m";
    case Quantity::solid_mass:
      return "kg";
    default:
      return "1";
  }
}

json::Value to_json(const Target& t) {
  json::Value document =
      json::Value::object({{"experiment", t.experiment},
                           {"quantity", name_of(t.quantity)},
                           {"time", t.time},
                           {"compartment", t.compartment == kEverywhere ? json::Value("all")
                                           : t.compartment == kOutlet   ? json::Value("outlet")
                                                                        : json::Value(t.compartment)}});
  if (t.quantity == Quantity::distribution)
    document.set("edges", t.edges).set("shares", t.shares);
  else
    document.set("value", t.value);
  return document.set("error", t.error).set("weight", t.weight).set("held_out", t.held_out);
}

}  // namespace granary::estimation
