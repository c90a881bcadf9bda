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

}  // namespace granary::run
