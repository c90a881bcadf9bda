#include "pilot/journal/journal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <optional>
#include <utility>

#include "common/files.hpp"
#include "common/json/io.hpp"

namespace granary::pilot {
namespace {

constexpr std::uint64_t kReserveStep = 256 * 1024;  ///< asked of the file system at a time [bytes]
constexpr std::uint64_t kReserveLow =
    64 * 1024;  ///< below this it is asked again: room for the last words of many tasks

// A line is BODY,"sum":"0123456789abcdef"} where BODY is the object without its closing brace.
constexpr std::string_view kSumOpens = ",\"sum\":\"";
constexpr std::size_t kSumDigits = 16;
constexpr std::size_t kSumLength = kSumOpens.size() + kSumDigits + 2;

std::string line_of(std::uint64_t sequence, double wall_time, const std::string& kind, const json::Value& payload) {
  std::string line = fmt::format(R"({{"n":{},"wall_s":{:.6f},"kind":{},"payload":{})", sequence, wall_time,
                                 json::dump(json::Value(kind)), json::dump(payload));
  line += fmt::format("{}{}\"}}", kSumOpens, fingerprint(line));
  return line;
}

/// Whether the line (without its newline) ends with the right checksum of what is before it.
bool has_good_sum(std::string_view line) {
  if (line.size() <= kSumLength) return false;
  const std::string_view body = line.substr(0, line.size() - kSumLength), sum = line.substr(body.size());
  return sum.starts_with(kSumOpens) && sum.ends_with("\"}") &&
         sum.substr(kSumOpens.size(), kSumDigits) == fingerprint(body);
}

/// The record of a line without its newline; nothing if the line is damaged or out of sequence.
std::optional<Record> record_of(std::string_view line, std::uint64_t expected_sequence) {
  if (!has_good_sum(line)) return std::nullopt;
  auto value = json::parse(std::string(line.substr(0, line.size() - kSumLength)) + "}", "journal");
  if (!value) return std::nullopt;
  Record record;
  record.sequence = static_cast<std::uint64_t>(value->integer_or("n", 0));
  if (record.sequence != expected_sequence) return std::nullopt;
  record.wall_time = value->number_or("wall_s", 0.0);
  record.kind = value->text_or("kind", "");
  if (json::Value* payload = value->find("payload")) record.payload = std::move(*payload);
  return record;
}

/// Whether any whole line from `begin` on carries its right checksum, whatever its number.
bool any_good_line(std::string_view text, std::size_t begin) {
  for (std::size_t end; (end = text.find('\n', begin)) != std::string_view::npos; begin = end + 1) {
    if (has_good_sum(text.substr(begin, end - begin))) return true;
  }
  return false;
}

Error write_error(const std::filesystem::path& file, int code) {
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

}  // namespace

Result<JournalContent> read_journal(const std::filesystem::path& file) {
  JournalContent content;
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return content;
  // A device such as /dev/full stands for a disk in tests; it holds nothing.
  if (!std::filesystem::is_regular_file(file, ignored)) return content;
  GRANARY_TRY(const std::string text, read_text(file));
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string::npos) break;
    auto record = record_of(std::string_view(text).substr(begin, end - begin), content.records.size() + 1);
    if (!record) {
      if (any_good_line(text, begin)) {
        return Error{fmt::format(
            "{}: line {} is damaged or missing, but good ones follow: this is no torn tail, somebody changed the file. "
            "Restore it from a copy, or start anew in another folder (--dir).",
            file.string(), content.records.size() + 1)};
      }
      break;
    }
    content.records.push_back(std::move(*record));
    begin = end + 1;
  }
  content.whole_bytes = begin;
  content.dropped_bytes = text.size() - begin;
  return content;
}

Result<Journal> Journal::open(const std::filesystem::path& file, std::function<double()> wall_clock) {
  GRANARY_TRY(JournalContent content, read_journal(file));
  Journal journal;
  journal.file_ = file;
  journal.wall_clock_ = wall_clock ? std::move(wall_clock) : system_wall_clock;
  journal.fd_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (journal.fd_ < 0) return write_error(file, errno);
  if (content.dropped_bytes > 0 && ::ftruncate(journal.fd_, static_cast<off_t>(content.whole_bytes)) != 0) {
    return write_error(file, errno);
  }
  journal.size_ = journal.reserved_ = content.whole_bytes;
  journal.next_sequence_ = content.records.size() + 1;
  journal.dropped_bytes_ = content.dropped_bytes;
  journal.records_ = std::move(content.records);
  journal.health_ = journal.reserve();
  return journal;
}

Journal Journal::in_memory(std::function<double()> wall_clock) {
  Journal journal;
  journal.in_memory_ = true;
  journal.wall_clock_ = wall_clock ? std::move(wall_clock) : system_wall_clock;
  return journal;
}

Journal::Journal(Journal&& other) noexcept { *this = std::move(other); }

Journal& Journal::operator=(Journal&& other) noexcept {
  std::swap(fd_, other.fd_);
  in_memory_ = other.in_memory_;
  file_ = std::move(other.file_);
  wall_clock_ = std::move(other.wall_clock_);
  records_ = std::move(other.records_);
  dropped_bytes_ = other.dropped_bytes_;
  next_sequence_ = other.next_sequence_;
  size_ = other.size_;
  reserved_ = other.reserved_;
  dirty_ = other.dirty_;
  health_ = std::move(other.health_);
  return *this;
}

Journal::~Journal() {
  if (fd_ < 0) return;
  (void)sync();
  // Gives back what the file system has reserved behind the last record.
  if (reserved_ > size_ && ::ftruncate(fd_, static_cast<off_t>(size_)) != 0) { /* it stays reserved, no harm */
  }
  ::close(fd_);
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

Status Journal::append(const std::string& kind, const json::Value& payload) {
  const double wall_time = wall_clock_();
  if (in_memory_) {
    records_.push_back({next_sequence_++, wall_time, kind, payload});
    return {};
  }
  const std::string line = line_of(next_sequence_, wall_time, kind, payload) + "\n";
  std::size_t written = 0;
  while (written < line.size()) {
    const ssize_t n = ::pwrite(fd_, line.data() + written, line.size() - written, static_cast<off_t>(size_ + written));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const int code = n < 0 ? errno : EIO;
      // Half a record must not stay behind: a later one would be written over its beginning only.
      if (written > 0 && ::ftruncate(fd_, static_cast<off_t>(size_)) == 0) reserved_ = size_;
      health_ = write_error(file_, code);
      return health_;
    }
    written += static_cast<std::size_t>(n);
  }
  size_ += line.size();
  ++next_sequence_;
  dirty_ = true;
  health_ = reserve();
  return {};
}

Status Journal::healthy() const { return health_; }

Status Journal::sync() {
  if (!dirty_ || in_memory_) return {};
  dirty_ = false;
  if (::fdatasync(fd_) != 0 && errno != EINVAL && errno != EROFS) return health_ = write_error(file_, errno);
  return {};
}

}  // namespace granary::pilot
