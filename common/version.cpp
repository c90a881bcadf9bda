#include "common/version.hpp"

namespace granary {

std::string_view version() { return GRANARY_VERSION; }
std::string_view revision() { return GRANARY_REVISION; }

}  // namespace granary
