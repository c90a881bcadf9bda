// What the data cannot tell apart, in words.
#pragma once

#include <string>
#include <vector>

#include "estimation/problem/parameter.hpp"
#include "estimation/trust/uncertainty.hpp"

namespace granary::estimation {

/// A sentence or two about one combination of parameters: "Only the product of A and B is known ..."
std::string sentence_of(const Unidentified& combination, const std::vector<Parameter>& parameters);

}  // namespace granary::estimation
