// Reading a workflow that was kept as a document. Private to controller/campaign.
#pragma once

#include "controller/campaign/campaign.hpp"

namespace granary::campaign {

/// Like read_campaign(), from a document: `file` opens the messages, relative paths start at `folder`.
Result<Campaign> reread_campaign(json::Value document, const std::filesystem::path& file,
                                 const std::filesystem::path& folder);

}  // namespace granary::campaign
