// A Unix socket in a folder, however long the folder's name is.
#pragma once

#include <filesystem>

#include "common/result.hpp"

namespace granary::pilot {

/// A new socket bound to DIR/control.sock, listening, mode 0600. The caller closes it.
Result<int> listen_at(const std::filesystem::path& dir);
/// A socket connected to DIR/control.sock, or -1 with errno set (ENOENT, ECONNREFUSED: nobody is there).
int connect_to(const std::filesystem::path& dir);
/// The user at the other end; -1 if the system does not say.
int peer_uid(int socket);

}  // namespace granary::pilot
