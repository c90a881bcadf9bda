#include "controller/run/handover.hpp"

namespace granary::run {
namespace {
std::string with_attempt(std::string name, int attempt) {
  return attempt > 1 ? name + "." + std::to_string(attempt) : name;
}
}  // namespace

std::string program_name(const coupling::BurstId& burst, int attempt) { return with_attempt(burst.folder(), attempt); }
std::string monitor_name(const coupling::BurstId& burst, int attempt) {
  return with_attempt(burst.folder() + "-monitor", attempt);
}

std::string kind_of_task(const std::string& name, bool fill) {
  if (fill) return "estimation";
  if (name.find("-monitor") != std::string::npos) return "monitor";
  if (name.find("-dem") != std::string::npos) return "dem";
  if (name.find("-pbm") != std::string::npos) return "pbm";
  return "other";
}

}  // namespace granary::run
