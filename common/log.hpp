// One line per event on stderr, with time and component. What a person watches; the journal is what we rely on.
#pragma once

#include <string_view>

namespace granary::log {

enum class Level { debug, info, warning, error, off };
void set_level(Level level);
void debug(std::string_view component, std::string_view message);
void info(std::string_view component, std::string_view message);
void warning(std::string_view component, std::string_view message);
void error(std::string_view component, std::string_view message);

}  // namespace granary::log
