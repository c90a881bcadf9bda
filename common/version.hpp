// Which Granary this is, for provenance.
#pragma once

#include <string_view>

namespace granary {

std::string_view version();   ///< "0.1.0"
std::string_view revision();  ///< the commit it was built from, "unknown" outside a checkout

}  // namespace granary
