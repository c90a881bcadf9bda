#include "common/log.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

namespace granary::log {
namespace {

spdlog::logger& logger() {
  static const auto instance = [] {
    auto made = spdlog::stderr_color_mt("granary");
    made->set_pattern("%H:%M:%S.%e %^%-5l%$ %v");
    return made;
  }();
  return *instance;
}

void write(spdlog::level::level_enum level, std::string_view component, std::string_view message) {
  logger().log(level, "{}: {}", component, message);
}

}  // namespace

void set_level(Level level) {
  static constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info,
                                                          spdlog::level::warn, spdlog::level::err, spdlog::level::off};
  logger().set_level(kLevels[static_cast<int>(level)]);
}
void debug(std::string_view component, std::string_view message) { write(spdlog::level::debug, component, message); }
void info(std::string_view component, std::string_view message) { write(spdlog::level::info, component, message); }
void warning(std::string_view component, std::string_view message) { write(spdlog::level::warn, component, message); }
void error(std::string_view component, std::string_view message) { write(spdlog::level::err, component, message); }

}  // namespace granary::log
