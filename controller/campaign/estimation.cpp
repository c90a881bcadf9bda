#include "controller/campaign/estimation.hpp"

#include <fmt/format.h>

namespace granary::campaign {

std::string_view name_of(Estimation::Adopt adopt) {
  switch (adopt) {
    case Estimation::Adopt::never:
      return "never";
    case Estimation::Adopt::end:
      return "end";
    case Estimation::Adopt::continuously:
      return "continuously";
  }
  return "";
}

std::string unit_of(estimation::Quantity quantity, int compartment) {
  const bool rate = compartment == estimation::kOutlet;
  if (quantity == estimation::Quantity::number) return rate ? "1/s" : "1";
  if (quantity == estimation::Quantity::solid_mass) return rate ? "kg/s" : "kg";
  return estimation::unit_of(quantity);
}

std::string shown(double value, const std::string& unit) {
  if (unit == "m") return fmt::format("{:.4g} um", 1e6 * value);
  return unit == "1" ? fmt::format("{:.4g}", value) : fmt::format("{:.4g} {}", value, unit);
}

json::Value to_json(const Estimation& e) {
  json::Value parameters = json::Value::array(), fixed = json::Value::array();
  for (const auto& one : e.parameters)
    parameters.push(json::Value::object({{"key", one.key}, {"unit", one.unit}, {"is", estimation::to_json(one.is)}}));
  for (const auto& one : e.fixed)
    fixed.push(json::Value::object({{"key", one.key}, {"unit", one.unit}, {"value", one.value}}));
  json::Value experiments = json::Value::array(), targets = json::Value::array();
  for (const auto& one : e.experiments) {
    pbm::PbmCase balance = one.balance;
    balance.dem = one.rates;
    experiments.push(json::Value::object({{"name", one.name}, {"pbm_case", pbm::to_json(balance)}}));
  }
  for (const auto& one : e.targets) targets.push(estimation::to_json(one));
  return json::Value::object({{"parameters", parameters},
                              {"fixed", fixed},
                              {"experiments", experiments},
                              {"targets", targets},
                              {"sources", e.sources},
                              {"method", e.method},
                              {"seed", e.seed},
                              {"adopt", name_of(e.adopt)},
                              {"most_evaluations", e.most_evaluations}});
}

}  // namespace granary::campaign
