// What our fixes share in talking to LIGGGHTS.
#pragma once

#include <string>
#include <vector>

namespace granary::dem {

inline std::vector<std::string> fix_words(int narg, char** arg) { return {arg, arg + narg}; }

}  // namespace granary::dem
