// How long a bench may take.
#pragma once

#include <string_view>

namespace granary::bench {

enum class Effort { quick, usual, full };

inline std::string_view name_of(Effort effort) {
  return effort == Effort::quick ? "quick" : effort == Effort::usual ? "usual" : "full";
}
/// One of three by effort.
template <class T>
T by_effort(Effort effort, T quick, T usual, T full) {
  return effort == Effort::quick ? quick : effort == Effort::usual ? usual : full;
}

}  // namespace granary::bench
