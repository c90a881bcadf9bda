#include "pilot/journal/journal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "common/json/text.hpp"

namespace granary::pilot {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kReserveStep = 256 * 1024;  ///< asked of the file system at a time [bytes]
constexpr std::uint64_t kReserveLow =
    64 * 1024;  ///< below this it is asked again: room for the last words of many tasks
/// More is written out at once, so that a flush always fits into the reserve [bytes].
constexpr std::size_t kLargestBuffer = 32 * 1024;
constexpr std::size_t kReadAtOnce = 1024 * 1024;

Error write_error(const fs::path& file, int code) {
  if (code == ENOSPC || code == EDQUOT) {
    return {
        fmt::format(
            "{}: the disk is full ({}). Make room and go on with `granary resume`; nothing that has finished is lost.",
            file.string(), std::strerror(code)),
        Exit::stopped};
  }
  return {fmt::format("{}: cannot be written: {}", file.string(), std::strerror(code)), Exit::stopped};
}

double system_wall_clock() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// 0, or what went wrong.
int sync_file(int fd) { return ::fdatasync(fd) != 0 && errno != EINVAL && errno != EROFS ? errno : 0; }

/// The whole lines of a file, one after the other.
class Lines {
 public:
  static Result<Lines> of(const fs::path& file) {
    Lines lines;
    lines.file_ = file;
    lines.fd_ = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status = {};
    // A device such as /dev/full stands for a disk in tests; it holds nothing.
    if (lines.fd_ >= 0 && fstat(lines.fd_, &status) == 0 && !S_ISREG(status.st_mode)) lines.at_end_ = true;
    if (lines.fd_ < 0 && errno == ENOENT) lines.at_end_ = true;
    if (lines.fd_ < 0 && !lines.at_end_) return lines.read_error();
    return lines;
  }
  Lines(Lines&& other) noexcept { *this = std::move(other); }
  Lines& operator=(Lines&& other) noexcept {
    std::swap(fd_, other.fd_);
    file_ = std::move(other.file_);
    buffer_ = std::move(other.buffer_);
    used_ = other.used_;
    at_end_ = other.at_end_;
    return *this;
  }
  ~Lines() {
    if (fd_ >= 0) ::close(fd_);
  }

  /// The next one without its newline, valid until the next call; nothing at the end.
  Result<std::optional<std::string_view>> next() {
    for (std::size_t search = used_;;) {
      const std::size_t end = buffer_.find('\n', search);
      if (end != std::string::npos) {
        const std::string_view line = std::string_view(buffer_).substr(used_, end - used_);
        used_ = end + 1;
        return std::optional(line);
      }
      if (at_end_) return std::optional<std::string_view>();
      buffer_.erase(0, std::exchange(used_, 0));
      search = buffer_.size();
      buffer_.resize(search + kReadAtOnce);
      const ssize_t n = ::read(fd_, buffer_.data() + search, kReadAtOnce);
      if (n < 0 && errno != EINTR) return read_error();
      buffer_.resize(search + static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
      at_end_ = n == 0;
    }
  }
  /// Bytes of a last line without newline, once next() has given nothing.
  std::size_t rest() const { return buffer_.size() - used_; }

 private:
  Lines() = default;
  Error read_error() const { return {fmt::format("{}: cannot be read: {}", file_.string(), std::strerror(errno))}; }

  int fd_ = -1;
  fs::path file_;
  std::string buffer_;
  std::size_t used_ = 0;
  bool at_end_ = false;
};

struct Extent {
  std::uint64_t whole_bytes = 0, records = 0;
  std::size_t dropped_bytes = 0;
};

/// Goes through the whole records of a file; what damage there is, is told or refused.
Result<Extent> scan(const fs::path& file, const std::function<Status(const Line&)>& fn) {
  GRANARY_TRY(Lines lines, Lines::of(file));
  Extent extent;
  bool damaged = false;
  while (true) {
    GRANARY_TRY(const auto text, lines.next());
    if (!text) break;
    const bool good = has_good_sum(*text);
    const auto line = good ? read_line(*text) : std::nullopt;
    if (damaged ? good : good && (!line || line->sequence != extent.records + 1)) {
      return Error{fmt::format(
          "{}: line {} is damaged or missing, but good ones follow: this is no torn tail, somebody changed the file. "
          "Restore it from a copy, or start anew in another folder (--dir).",
          file.string(), extent.records + 1)};
    }
    damaged = damaged || !good;
    if (damaged) {
      extent.dropped_bytes += text->size() + 1;
      continue;
    }
    GRANARY_CHECK(fn(*line));
    ++extent.records;
    extent.whole_bytes += text->size() + 1;
  }
  extent.dropped_bytes += lines.rest();
  return extent;
}

Record record_of(const Line& line) {
  return {line.sequence, line.wall_time, std::string(line.kind),
          json::parse_text(line.payload).value_or(json::Value())};
}

}  // namespace

Result<JournalContent> read_journal(const fs::path& file) {
  JournalContent content;
  GRANARY_TRY(const Extent extent, scan(file, [&](const Line& line) {
                content.records.push_back(record_of(line));
                return Status();
              }));
  content.whole_bytes = extent.whole_bytes;
  content.dropped_bytes = extent.dropped_bytes;
  return content;
}

Result<Journal> Journal::open(const fs::path& file, std::function<double()> wall_clock) {
  Journal journal;
  GRANARY_TRY(const Extent extent, scan(file, [&](const Line& line) {
                if (!journal.first_wall_time_) journal.first_wall_time_ = line.wall_time;
                return Status();
              }));
  journal.file_ = file;
  journal.wall_clock_ = wall_clock ? std::move(wall_clock) : system_wall_clock;
  journal.fd_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (journal.fd_ < 0) return write_error(file, errno);
  if (extent.dropped_bytes > 0 && ::ftruncate(journal.fd_, static_cast<off_t>(extent.whole_bytes)) != 0) {
    return write_error(file, errno);
  }
  journal.size_ = journal.reserved_ = extent.whole_bytes;
  journal.next_sequence_ = extent.records + 1;
  journal.dropped_bytes_ = extent.dropped_bytes;
  journal.health_ = journal.reserve();
  return journal;
}

Journal Journal::in_memory(std::function<double()> wall_clock) {
  Journal journal;
  journal.wall_clock_ = wall_clock ? std::move(wall_clock) : system_wall_clock;
  return journal;
}

Result<Journal> Journal::copy_of(const fs::path& file) {
  Journal copy = in_memory();
  std::error_code ignored;
  if (fs::is_regular_file(file, ignored)) copy.buffer_.reserve(fs::file_size(file, ignored) + kReadAtOnce);
  GRANARY_TRY(const Extent extent, scan(file, [&](const Line& line) {
                if (!copy.first_wall_time_) copy.first_wall_time_ = line.wall_time;
                copy.buffer_.append(line.text) += '\n';
                return Status();
              }));
  copy.next_sequence_ = extent.records + 1;
  copy.dropped_bytes_ = extent.dropped_bytes;
  return copy;
}

Journal::Journal(Journal&& other) noexcept { *this = std::move(other); }

Journal& Journal::operator=(Journal&& other) noexcept {
  std::swap(fd_, other.fd_);
  file_ = std::move(other.file_);
  wall_clock_ = std::move(other.wall_clock_);
  stamp_ = other.stamp_;
  first_wall_time_ = other.first_wall_time_;
  std::swap(buffer_, other.buffer_);
  dropped_bytes_ = other.dropped_bytes_;
  next_sequence_ = other.next_sequence_;
  buffered_ = other.buffered_;
  size_ = other.size_;
  reserved_ = other.reserved_;
  dirty_ = other.dirty_;
  health_ = std::move(other.health_);
  std::swap(syncing_, other.syncing_);
  return *this;
}

Journal::~Journal() {
  if (fd_ < 0) return;
  (void)flush();
  (void)sync();  // also waits for the one beside us, whose file must stay open
  // Gives back what the file system has reserved behind the last record.
  if (reserved_ > size_ && ::ftruncate(fd_, static_cast<off_t>(size_)) != 0) { /* it stays reserved, no harm */
  }
  ::close(fd_);
}

Status Journal::for_each(const std::function<Status(const Line&)>& fn) const {
  if (fd_ >= 0) {
    const auto extent = scan(file_, fn);
    return extent ? Status() : Status(extent.error());
  }
  for (std::size_t begin = 0; begin < buffer_.size();) {
    const std::size_t end = buffer_.find('\n', begin);
    GRANARY_CHECK(fn(*read_line(std::string_view(buffer_).substr(begin, end - begin))));
    begin = end + 1;
  }
  return {};
}

std::vector<Record> Journal::records(std::string_view kind) const {
  std::vector<Record> records;
  (void)for_each([&](const Line& line) {
    if (line.kind.starts_with(kind)) records.push_back(record_of(line));
    return Status();
  });
  return records;
}

Status Journal::reserve() {
  if (reserved_ >= size_ + kReserveLow) return {};
  const std::uint64_t wanted = size_ + kReserveStep - reserved_;
  if (::fallocate(fd_, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(reserved_), static_cast<off_t>(wanted)) == 0) {
    reserved_ += wanted;
    return {};
  }
  // Not every file system can promise space; then a full disk is only seen by the write itself.
  return errno == ENOSPC || errno == EDQUOT ? Status(write_error(file_, errno)) : Status();
}

void Journal::add(std::string_view kind, std::string_view payload) {
  const double wall_time = stamp_ ? *stamp_ : wall_clock_();
  if (!first_wall_time_) first_wall_time_ = wall_time;
  append_line(buffer_, {next_sequence_++, wall_time, kind, payload});
  ++buffered_;
  if (fd_ >= 0 && buffer_.size() > kLargestBuffer) (void)flush();
}

Status Journal::append(const std::string& kind, const json::Value& payload) {
  std::string text;
  json::append(text, payload);
  add(kind, text);
  return flush();
}

Status Journal::flush() {
  if (fd_ < 0 || buffer_.empty()) return {};
  const Status written = write_out();
  buffer_.clear();
  const std::uint64_t lines = std::exchange(buffered_, 0);
  if (!written) {
    next_sequence_ -= lines;  // so that what can be written later follows on what is there
    return health_ = written;
  }
  dirty_ = true;
  health_ = reserve();
  return {};
}

Status Journal::write_out() {
  std::size_t written = 0;
  while (written < buffer_.size()) {
    const ssize_t n =
        ::pwrite(fd_, buffer_.data() + written, buffer_.size() - written, static_cast<off_t>(size_ + written));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const int code = n < 0 ? errno : EIO;
      // Half a record must not stay behind: a later one would be written over its beginning only.
      if (written > 0 && ::ftruncate(fd_, static_cast<off_t>(size_)) == 0) reserved_ = size_;
      return write_error(file_, code);
    }
    written += static_cast<std::size_t>(n);
  }
  size_ += buffer_.size();
  return {};
}

Status Journal::healthy() const { return health_; }

Status Journal::sync() {
  if (syncing_.valid()) {
    if (const int code = syncing_.get(); code != 0) return health_ = write_error(file_, code);
  }
  if (!dirty_ || fd_ < 0) return {};
  dirty_ = false;
  if (const int code = sync_file(fd_); code != 0) return health_ = write_error(file_, code);
  return {};
}

Status Journal::sync_beside() {
  if (syncing_.valid()) {
    if (syncing_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
    if (const int code = syncing_.get(); code != 0) return health_ = write_error(file_, code);
  }
  if (!dirty_ || fd_ < 0) return {};
  dirty_ = false;
  syncing_ = std::async(std::launch::async, sync_file, fd_);
  return {};
}

Status Journal::rewrite(const std::function<void(Journal&)>& write) {
  if (fd_ < 0) return {};
  fs::path beside = file_;
  beside += ".new";
  std::error_code error;
  fs::remove(beside, error);
  GRANARY_TRY(Journal fresh, open(beside, wall_clock_));
  write(fresh);
  GRANARY_CHECK(fresh.flush());
  GRANARY_CHECK(fresh.healthy());
  GRANARY_CHECK(fresh.sync());
  fs::rename(beside, file_, error);
  if (error) return write_error(file_, error.value());
  fresh.file_ = file_;
  fresh.stamp_.reset();
  fresh.dropped_bytes_ = dropped_bytes_;
  buffer_.clear();
  dirty_ = false;
  reserved_ = size_;  // nothing to give back in the file that is no more
  *this = std::move(fresh);
  return {};
}

}  // namespace granary::pilot
