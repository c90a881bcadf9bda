// Small file helpers with errors that say what to do: a full disk and a missing file are no surprises.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace granary {

Result<std::string> read_text(const std::filesystem::path& file);
/// Writes beside the file, flushes to disk and renames over it.
Status write_text_atomically(const std::filesystem::path& file, std::string_view text);
Status make_folders(const std::filesystem::path& folder);
/// The folder of the running executable: our programs lie beside each other.
std::filesystem::path program_folder();
/// FNV-1a, 64 bits, as 16 hex digits: tells one case or state from another, not for security.
std::string fingerprint(std::string_view bytes);

}  // namespace granary
