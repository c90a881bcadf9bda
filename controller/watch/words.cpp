#include "controller/watch/words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace granary::watch {

std::string duration(double seconds) {
  const double s = std::max(0.0, seconds);
  if (s < 59.95) return fmt::format("{:.1f} s", s);
  const auto whole = static_cast<long>(std::lround(s));
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  if (whole < 48 * 3600) return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
  return fmt::format("{} d {:02} h", whole / 86400, whole / 3600 % 24);
}

std::string clock_of(double seconds) {
  const auto tenths = static_cast<long>(std::lround(10.0 * std::max(0.0, seconds)));
  const long whole = tenths / 10;
  if (whole < 3600) return fmt::format("{}:{:02}.{}", whole / 60, whole % 60, tenths % 10);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string left_words(double least, double most) {
  if (most - least < 0.5) return fmt::format("about {} left", duration(most));
  if (least < 0.5) return fmt::format("at most {} left", duration(most));
  return fmt::format("{} to {} left", duration(least), duration(most));
}

std::string percent(double share) { return fmt::format("{:.3g} %", 100.0 * share); }

std::string micrometres(double metres) { return fmt::format("{:.3g} um", 1e6 * metres); }

std::string burst_words(std::string_view folder) {
  const auto dash = folder.find('-');
  const bool numbered = dash != std::string_view::npos && dash > 0 &&
                        std::all_of(folder.begin(), folder.begin() + static_cast<std::ptrdiff_t>(dash),
                                    [](unsigned char c) { return std::isdigit(c) != 0; });
  if (!numbered) return std::string(folder);
  const std::string_view kind = folder.substr(dash + 1);
  if (kind != "dem" && kind != "pbm") return std::string(folder);
  std::string_view number = folder.substr(0, dash);
  number.remove_prefix(std::min(number.find_first_not_of('0'), number.size() - 1));
  return fmt::format("{} burst {}", kind == "dem" ? "DEM" : "PBM", number);
}

std::string property_words(std::string_view property) {
  if (property == "d50_m") return "d50";
  if (property == "collision_frequency" || property == "collisions_per_particle_s") return "collision rate";
  if (property == "impact_frequency" || property == "impacts_per_particle_s") return "impact rate";
  if (property == "speed_mean_m_s") return "mean speed";
  if (property == "number") return "particle number";
  return std::string(property);
}

std::string plural(long count, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

}  // namespace granary::watch
