#include "common/results/sealed_bytes.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <utility>

namespace granary {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kMagic = "granary-seal-1";
constexpr std::uint64_t kSlot = SealedBytes::kHead / 2;  // two seals, written in turns: one of them is always whole
constexpr std::uint64_t kBlock = SealedBytes::kBlock;
constexpr std::uint64_t kEntry = 8 + kBlock;  // of the journal: where a block belongs, and the block

std::uint64_t blocks_of(std::uint64_t length) { return (length + kBlock - 1) / kBlock; }

/// Each step is a bijection of the hash for a given word and of the word for a given hash, so a change of a single word
/// is always seen, and others but for one in 2^64.
std::uint64_t mixed(std::uint64_t hash, std::uint64_t word) {
  return std::rotl((hash ^ word) * 0x9E3779B97F4A7C15ULL, 29);
}

std::uint64_t sum_of(std::string_view bytes, std::uint64_t start) {
  std::uint64_t hash = mixed(bytes.size(), start), word = 0;
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    word = 0;
    std::memcpy(&word, bytes.data() + at, std::min<std::size_t>(8, bytes.size() - at));
    hash = mixed(hash, word);
  }
  return mixed(hash, hash >> 32);
}

std::uint64_t block_sum(std::uint64_t block, const SealedBytes::Block& content) {
  return sum_of({content.data(), content.size()}, block);
}

/// One slot: a line a person can read, padded with zeros.
std::string text_of(const Seal& seal) {
  std::string text =
      fmt::format("{} sequence={:016x} length={:016x} sum={:016x} journal_blocks={:016x} journal_sum={:016x}", kMagic,
                  seal.sequence, seal.length, seal.sum, seal.journal_blocks, seal.journal_sum);
  text += fmt::format(" check={:016x}\n", sum_of(text, 0));
  text.resize(kSlot, '\0');
  return text;
}

std::optional<Seal> seal_in(std::string_view slot) {
  Seal seal;
  std::size_t at = kMagic.size();
  for (const auto& [name, field] : {std::pair{"sequence", &seal.sequence},
                                    {"length", &seal.length},
                                    {"sum", &seal.sum},
                                    {"journal_blocks", &seal.journal_blocks},
                                    {"journal_sum", &seal.journal_sum}}) {
    at += std::strlen(name) + 2;
    std::from_chars(slot.data() + at, slot.data() + at + 16, *field, 16);
    at += 16;
  }
  // What reads back to the same text was read right, its check included.
  if (text_of(seal) == slot) return seal;
  return std::nullopt;
}

bool read_all(int fd, std::uint64_t at, std::size_t size, char* to) {
  while (size > 0) {
    const ssize_t n = ::pread(fd, to, size, static_cast<off_t>(at));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    if (n == 0) return std::memset(to, 0, size), true;  // behind the end
    at += static_cast<std::uint64_t>(n), to += n, size -= static_cast<std::size_t>(n);
  }
  return true;
}

bool write_all(int fd, const SealedBytes::Write& write) {
  for (std::size_t done = 0; done < write.bytes.size();) {
    const ssize_t n =
        ::pwrite(fd, write.bytes.data() + done, write.bytes.size() - done, static_cast<off_t>(write.at + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return true;
}

/// Adds a block to the last write if it follows it, else as a write of its own.
void add(std::vector<SealedBytes::Write>& writes, std::uint64_t block, const SealedBytes::Block& content) {
  const std::uint64_t at = block * kBlock;
  // The seals in front of block 0 are not the content's to write.
  const std::uint64_t skip = block == 0 ? SealedBytes::kHead : 0;
  const std::string_view bytes(content.data() + skip, content.size() - skip);
  if (!writes.empty() && writes.back().at + writes.back().bytes.size() == at + skip) {
    writes.back().bytes += bytes;
  } else {
    writes.push_back({at + skip, std::string(bytes)});
  }
}

/// A network file system may know no locks: then go on without.
bool taken_by_another(int fd, int how) { return ::flock(fd, how | LOCK_NB) != 0 && errno == EWOULDBLOCK; }

Error in_use(const fs::path& file) {
  return {file.string() + ": another program has it open. Wait until it ends, or stop it."};
}

Error damaged(const fs::path& file, const std::string& how) {
  return {fmt::format("{}: the file is damaged: {}. Take another checkpoint or output file.", file.string(), how)};
}

}  // namespace

Result<SealedBytes> SealedBytes::create(const fs::path& file) {
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0)
    return Error{fmt::format("{}: cannot be made: {}.", file.string(), std::strerror(errno)), Exit::task_failed};
  SealedBytes made(fd, file, true);
  if (taken_by_another(fd, LOCK_EX)) return in_use(file);
  if (::ftruncate(fd, 0) != 0)
    return Error{fmt::format("{}: cannot be emptied: {}.", file.string(), std::strerror(errno)), Exit::task_failed};
  made.seal_.length = kHead;
  made.block_sum_ = {block_sum(0, Block(kBlock, '\0'))};
  made.seal_.sum = made.block_sum_[0];
  return made;
}

Result<SealedBytes> SealedBytes::open(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return Error{file.string() + ": there is no such file."};
  if (!fs::is_regular_file(file, ignored)) return Error{file.string() + ": is a folder or device; a file is wanted."};
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return Error{fmt::format("{}: cannot be read: {}.", file.string(), std::strerror(errno))};
  SealedBytes opened(fd, file, false);
  if (taken_by_another(fd, LOCK_SH)) return in_use(file);
  GRANARY_CHECK(opened.verify());
  return opened;
}

bool SealedBytes::seems_sealed(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return false;
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  std::array<char, kHead> head{};
  const bool read = read_all(fd, 0, head.size(), head.data());
  ::close(fd);
  const auto starts = [&](std::uint64_t at) { return std::string_view(head.data() + at, kMagic.size()) == kMagic; };
  return read && (starts(0) || starts(kSlot));
}

SealedBytes::SealedBytes(SealedBytes&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      file_(std::move(other.file_)),
      writable_(other.writable_),
      size_(other.size_),
      seal_(other.seal_),
      block_sum_(std::move(other.block_sum_)),
      over_disk_(std::move(other.over_disk_)) {}

SealedBytes::~SealedBytes() {
  if (fd_ >= 0) ::close(fd_);
}

/// Takes the newer whole seal, puts the blocks of an open journal over those on disk, and adds up all there is.
Status SealedBytes::verify() {
  struct stat info {};
  std::string head(kHead, '\0');
  if (::fstat(fd_, &info) != 0 || !read_all(fd_, 0, head.size(), head.data()))
    return Error{fmt::format("{}: cannot be read: {}.", file_.string(), std::strerror(errno))};
  const auto on_disk = static_cast<std::uint64_t>(info.st_size);
  std::optional<Seal> newest;
  for (const std::uint64_t at : {std::uint64_t{0}, kSlot})
    if (const auto seal = seal_in(std::string_view(head).substr(at, kSlot)))
      if (!newest || seal->sequence > newest->sequence) newest = seal;
  if (!newest)
    return Error{
        fmt::format("{}: it has no whole seal ({}): it is damaged, or no state file of granary-pbm. "
                    "Take an out.h5 or checkpoint.h5.",
                    file_.string(), kMagic)};
  seal_ = *newest;
  const std::uint64_t journal_at = blocks_of(seal_.length) * kBlock;
  if (seal_.length < kHead || seal_.length > on_disk)
    return damaged(file_, fmt::format("it has {} bytes of {}", on_disk, seal_.length));
  if (seal_.journal_blocks > on_disk / kEntry || (seal_.journal_blocks > 0 && journal_at > on_disk))
    return damaged(file_, "its journal is cut short");
  std::string journal(seal_.journal_blocks * kEntry, '\0');
  if (!read_all(fd_, journal_at, journal.size(), journal.data()) ||
      (!journal.empty() && sum_of(journal, 0) != seal_.journal_sum))
    return damaged(file_, "its journal does not match its checksum");
  for (std::size_t at = 0; at < journal.size(); at += kEntry) {
    std::uint64_t block = 0;
    std::memcpy(&block, &journal[at], 8);
    over_disk_[block].assign(journal.begin() + static_cast<std::ptrdiff_t>(at + 8),
                             journal.begin() + static_cast<std::ptrdiff_t>(at + kEntry));
  }
  size_ = seal_.length;
  std::uint64_t sum = 0;
  Block content;
  for (std::uint64_t block = 0; block < blocks_of(size_); ++block) {
    if (!load(block, content))
      return Error{
          fmt::format("{}: cannot be read at byte {}: {}.", file_.string(), block * kBlock, std::strerror(errno))};
    sum += block_sum(block, content);
  }
  if (sum == seal_.sum) return {};
  return damaged(file_, fmt::format("its {} bytes do not match the checksum they were written with", size_));
}

/// A block as it stands now; without the seals, and zero behind the end.
bool SealedBytes::load(std::uint64_t block, Block& content) const {
  if (const auto found = over_disk_.find(block); found != over_disk_.end()) return content = found->second, true;
  content.assign(kBlock, '\0');
  const std::uint64_t from = block == 0 ? kHead : block * kBlock;
  const std::uint64_t end = std::min(seal_.length, (block + 1) * kBlock);
  return from >= end || read_all(fd_, from, end - from, content.data() + from - block * kBlock);
}

bool SealedBytes::read(std::uint64_t at, std::size_t size, char* to) const {
  Block content;
  while (size > 0) {
    const std::uint64_t within = at % kBlock;
    const std::size_t n = std::min<std::size_t>(size, kBlock - within);
    if (!load(at / kBlock, content)) return false;
    std::memcpy(to, content.data() + within, n);
    at += n, to += n, size -= n;
  }
  return true;
}

bool SealedBytes::write(std::uint64_t at, std::size_t size, const char* from) {
  if (!writable_ || at < kHead) return false;
  size_ = std::max(size_, at + size);
  while (size > 0) {
    const std::uint64_t within = at % kBlock;
    const std::size_t n = std::min<std::size_t>(size, kBlock - within);
    auto place = over_disk_.find(at / kBlock);
    if (place == over_disk_.end()) {
      Block content;
      if (!load(at / kBlock, content)) return false;
      place = over_disk_.emplace(at / kBlock, std::move(content)).first;
    }
    std::memcpy(place->second.data() + within, from, n);
    at += n, from += n, size -= n;
  }
  return true;
}

/// New blocks go straight behind the old end, which no seal knows yet. Changed ones first go into a journal behind
/// them: from the seal that names the journal on, the new content counts, and their places can be overwritten.
std::vector<SealedBytes::Write> SealedBytes::plan(std::uint64_t length) {
  length = std::max(length, size_);
  const std::uint64_t n_before = blocks_of(seal_.length), n_after = blocks_of(length);
  block_sum_.resize(n_after);
  for (std::uint64_t block = n_before; block < n_after; ++block) over_disk_.try_emplace(block, Block(kBlock, '\0'));
  std::vector<Write> fresh, changed;
  std::string journal;
  std::uint64_t n_changed = 0;
  for (const auto& [block, content] : over_disk_) {
    block_sum_[block] = block_sum(block, content);
    if (block >= n_before) {
      add(fresh, block, content);
      continue;
    }
    ++n_changed;
    journal.append(reinterpret_cast<const char*>(&block), 8);
    journal.append(content.data(), content.size());
    add(changed, block, content);
  }
  std::uint64_t sum = 0;
  for (const std::uint64_t one : block_sum_) sum += one;

  std::vector<Write> steps = std::move(fresh);
  const auto seal = [&](const Seal& next) {
    seal_ = next;
    steps.push_back({next.sequence % 2 * kSlot, text_of(next)});
  };
  if (n_changed > 0) {
    const std::uint64_t sequence = seal_.sequence + 1, journal_sum = sum_of(journal, 0);
    steps.push_back({n_after * kBlock, std::move(journal)});
    seal({sequence, length, sum, n_changed, journal_sum});
    std::move(changed.begin(), changed.end(), std::back_inserter(steps));
  }
  seal({seal_.sequence + 1, length, sum, 0, 0});
  over_disk_.clear();
  size_ = length;
  return steps;
}

bool SealedBytes::commit(std::uint64_t length) {
  if (!writable_) return false;
  if (over_disk_.empty() && length <= seal_.length && seal_.sequence > 0) return true;
  for (const Write& step : plan(length))
    if (!write_all(fd_, step)) return writable_ = false;
  // What is left of the journal, and the zeros behind the end in the last block.
  return ::ftruncate(fd_, static_cast<off_t>(size_)) == 0;
}

bool SealedBytes::sync() const { return ::fsync(fd_) == 0; }

}  // namespace granary
