// What is fitted: a number of the population balance's case, with the bounds within which it is looked for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/json/value.hpp"

namespace granary::estimation {

enum class Scale { linear, log };

/// What is known of a parameter beforehand: a normal distribution on its scale.
struct Prior {
  double mean = 0.0;       ///< in the parameter's own unit
  double deviation = 1.0;  ///< linear: in the parameter's own unit; log: decades; > 0
};

struct Parameter {
  std::string name;     ///< for people: "aggregation rate"
  std::string pointer;  ///< into every case: "/aggregation/rate"
  double low = 0.0, high = 1.0;
  Scale scale = Scale::linear;  ///< log: 0 < low
  std::optional<Prior> prior;
  std::optional<double> start;  ///< where the search begins; none: the middle of the bounds, on the scale

  /// Between the bounds as a number from 0 to 1, and back.
  double place_of(double value) const;
  double value_at(double place) const;
};

/// shape (parameters): values at a point of the unit cube, and back.
std::vector<double> values_at(const std::vector<Parameter>& parameters, const std::vector<double>& point);
std::vector<double> places_of(const std::vector<Parameter>& parameters, const std::vector<double>& values);

/// The case with these values in their places: what a trial runs, and what a campaign adopts. Each place must hold a
/// number already (see read_problem).
json::Value with_parameters(json::Value pbm_case, const std::vector<Parameter>& parameters,
                            const std::vector<double>& values);
/// The number that a case has at a pointer; none if it has no number there.
std::optional<double> number_at(const json::Value& pbm_case, const std::string& pointer);

json::Value to_json(const Parameter& parameter);

}  // namespace granary::estimation
