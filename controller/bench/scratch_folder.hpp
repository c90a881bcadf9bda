// A folder for what a bench writes, gone at its end, also when the bench is interrupted.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

namespace granary::bench {

/// While there is one, SIGINT, SIGTERM and SIGHUP (those that are not ignored) say so on stderr, take the folder away
/// and end the program with 128 + signal: make it before the first thread.
class ScratchFolder {
 public:
  /// A new one in `parent`; nothing if none can be made there.
  static std::optional<ScratchFolder> make(const std::filesystem::path& parent);
  ScratchFolder(ScratchFolder&& other) noexcept;
  ScratchFolder& operator=(ScratchFolder&&) = delete;
  ~ScratchFolder();
  const std::filesystem::path& path() const;

 private:
  struct Watched;
  explicit ScratchFolder(std::unique_ptr<Watched> watched);
  std::unique_ptr<Watched> watched_;
};

}  // namespace granary::bench
