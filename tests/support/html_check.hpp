// Is a page well formed? Enough of HTML for pages of our own: tags close in order, ids are unique, links inside the
// page have a target.
#pragma once

#include <string>
#include <string_view>

namespace granary::test {

/// "" if it is; else what is wrong, with what stands there.
std::string what_is_wrong_with_html(std::string_view page);

}  // namespace granary::test
