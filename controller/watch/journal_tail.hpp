// Follows a growing journal.jsonl without touching it: whole lines of good checksum, one after the other.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "pilot/journal/line.hpp"

namespace granary::watch {

class JournalTail {
 public:
  explicit JournalTail(std::filesystem::path file) : file_(std::move(file)) {}

  /// Gives `fn` the lines written since the last call. `again` is called first if the file is another one than before
  /// (written anew, or cut): then everything is read from its beginning. A file that does not exist is empty.
  void read(const std::function<void()>& again, const std::function<void(const pilot::Line&)>& fn);
  /// Lines passed over because their checksum is wrong, with good ones behind them.
  std::uint64_t damaged() const { return damaged_; }
  bool exists() const { return inode_ != 0; }

 private:
  std::filesystem::path file_;
  ino_t inode_ = 0;
  std::uint64_t offset_ = 0;  ///< behind the last line taken
  std::uint64_t bad_ = 0;     ///< bad lines since the last good one: a torn tail of a killed pilot, so far
  std::uint64_t damaged_ = 0;
};

}  // namespace granary::watch
