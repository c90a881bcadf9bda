// A folder for what a bench writes, gone at its end.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

namespace granary::bench {

class ScratchFolder {
 public:
  /// A new one in `parent`; nothing if none can be made there.
  static std::optional<ScratchFolder> make(const std::filesystem::path& parent) {
    std::string path = (parent / "granary-bench-XXXXXX").string();
    if (mkdtemp(path.data()) == nullptr) return std::nullopt;
    return ScratchFolder(path);
  }
  ScratchFolder(ScratchFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  ScratchFolder& operator=(ScratchFolder&&) = delete;
  ~ScratchFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  explicit ScratchFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

}  // namespace granary::bench
