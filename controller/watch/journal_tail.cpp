#include "controller/watch/journal_tail.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <utility>
#include <vector>

namespace granary::watch {

namespace {
constexpr std::size_t kChunk = std::size_t{1} << 20U;
}

void JournalTail::read(const std::function<void()>& again, const std::function<void(const pilot::Line&)>& fn) {
  const int fd = open(file_.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return;
  struct stat info = {};
  const bool known = fstat(fd, &info) == 0;
  if (known && (info.st_ino != inode_ || static_cast<std::uint64_t>(info.st_size) < offset_)) {
    if (inode_ != 0) again();
    inode_ = info.st_ino;
    offset_ = bad_ = damaged_ = 0;
  }
  std::string text;
  std::vector<char> chunk(kChunk);
  std::uint64_t at = offset_;
  for (ssize_t n; known && (n = pread(fd, chunk.data(), chunk.size(), static_cast<off_t>(at))) > 0;) {
    at += static_cast<std::uint64_t>(n);
    text.append(chunk.data(), static_cast<std::size_t>(n));
    std::size_t begin = 0;
    for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
      const std::string_view whole = std::string_view(text).substr(begin, end - begin);
      const auto line = pilot::has_good_sum(whole) ? pilot::read_line(whole) : std::nullopt;
      if (!line) {
        ++bad_;
        continue;
      }
      damaged_ += std::exchange(bad_, 0);
      fn(*line);
    }
    offset_ += begin;
    text.erase(0, begin);
  }
  close(fd);
}

}  // namespace granary::watch
