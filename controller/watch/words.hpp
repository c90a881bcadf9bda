// Numbers in the words a person reads: durations, shares, sizes.
#pragma once

#include <string>
#include <string_view>

namespace granary::watch {

/// "0.8 s", "12.4 s", "1 min 12 s", "2 h 05 min", "3 d 04 h".
std::string duration(double seconds);
/// "0:12.4", "1:02:03": for a column of times since the start.
std::string clock_of(double seconds);
/// "about 20.0 s left", "7.0 s to 4 min 37 s left", "at most 4 min 37 s left".
std::string left_words(double least, double most);
std::string percent(double share);       ///< "98.7 %", "100 %"
std::string micrometres(double metres);  ///< "106 um", "7.32 um"
/// "DEM burst 3" for "0003-dem", "PBM burst 3" for "0003-pbm"; else the name as it is.
std::string burst_words(std::string_view folder);
/// The name of what a verdict or a comparison looked at: "d50_m" is "d50", "collision_frequency" "collision rate".
std::string property_words(std::string_view property);
std::string plural(long count, std::string_view one, std::string_view many);  ///< "1 task", "3 tasks"

}  // namespace granary::watch
