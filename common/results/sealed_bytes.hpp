// A growing file whose every byte is under a checksum, and that is whole after every commit, whatever ends the program
// in between. Knows nothing of HDF5: the driver that puts HDF5 files into it is results/sealed_driver. Layout:
// docs/exchange_formats.md#seal.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace granary {

/// What stands at the front of a sealed file: how far it reaches and what its bytes add up to.
struct Seal {
  std::uint64_t sequence = 0;        ///< the higher of the two that a file holds counts
  std::uint64_t length = 0;          ///< bytes of the file, seals included; what lies behind is no part of it
  std::uint64_t sum = 0;             ///< sum of block_sum() over its blocks, mod 2^64
  std::uint64_t journal_blocks = 0;  ///< blocks that stand behind it and belong in their places (0 after a commit)
  std::uint64_t journal_sum = 0;

  bool operator==(const Seal&) const = default;
};

class SealedBytes {
 public:
  static constexpr std::uint64_t kHead = 512;  ///< the seals; content starts here
  static constexpr std::uint64_t kBlock = 4096;
  using Block = std::vector<char>;  ///< kBlock bytes, zero behind the end of the file

  /// One step of a commit: bytes to their place.
  struct Write {
    std::uint64_t at;
    std::string bytes;
  };

  /// An empty file, which replaces one that is there. Errors: it cannot be written; another program is writing it.
  static Result<SealedBytes> create(const std::filesystem::path& file);
  /// Reads every byte and holds it against the seal. Errors: no such file, no seal, cut short, damaged, being written.
  static Result<SealedBytes> open(const std::filesystem::path& file);
  /// Whether a file starts like a sealed one (it may be damaged all the same).
  static bool seems_sealed(const std::filesystem::path& file);

  SealedBytes(SealedBytes&& other) noexcept;
  SealedBytes& operator=(SealedBytes&&) = delete;
  ~SealedBytes();

  /// End of what has been written, committed or not.
  std::uint64_t size() const { return size_; }
  /// Bytes behind the end are zeros. False: the disk refuses.
  bool read(std::uint64_t at, std::size_t size, char* to) const;
  /// Kept in memory until the next commit. False: the file is read only, or the disk refuses.
  bool write(std::uint64_t at, std::size_t size, const char* from);
  /// Makes what was written part of the file, which then reaches to `length` at least (it never shrinks). All or
  /// nothing: killed anywhere in between, the file holds what it held before, or the new. False: the disk refuses; then
  /// nothing more can be written.
  bool commit(std::uint64_t length);
  /// On the disk itself, not only in the kernel's memory.
  bool sync() const;
  bool writable() const { return writable_; }

  /// The writes of commit(length) in their order, for whoever carries them out: what a kill can cut anywhere.
  std::vector<Write> plan(std::uint64_t length);

 private:
  SealedBytes(int fd, std::filesystem::path file, bool writable)
      : fd_(fd), file_(std::move(file)), writable_(writable) {}
  Status verify();
  bool load(std::uint64_t block, Block& content) const;

  int fd_ = -1;
  std::filesystem::path file_;
  bool writable_ = false;
  std::uint64_t size_ = kHead;
  Seal seal_;                                 ///< of the last commit
  std::vector<std::uint64_t> block_sum_;      ///< of the last commit, shape (blocks); only while writing
  std::map<std::uint64_t, Block> over_disk_;  ///< not yet in their places: uncommitted, or from an open journal
};

}  // namespace granary
