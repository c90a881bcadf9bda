// The campaign's memory: one line of JSON a record, appended before what it tells of is done. docs/journal_format.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::pilot {

struct Record {
  std::uint64_t sequence = 0;  ///< 1, 2, 3, ...
  double wall_time = 0.0;      ///< [s] since 1970-01-01 UTC
  std::string kind;            ///< "task.end", "coupling.event": the part before the dot is its writer's
  json::Value payload;
};

/// What a journal file holds.
struct JournalContent {
  std::vector<Record> records;
  std::uint64_t whole_bytes = 0;  ///< length of the whole records
  std::size_t dropped_bytes = 0;  ///< of a torn or corrupt tail behind them
};

/// Reads without changing the file. A file that does not exist is an empty journal. Only the tail may be damaged: a bad
/// line with a good one behind it is an error that names the line.
Result<JournalContent> read_journal(const std::filesystem::path& file);

class Journal {
 public:
  /// Opens DIR/journal.jsonl (or makes it) to go on behind its last whole record; a damaged tail is cut off.
  /// The caller holds the RunLock of the folder. `wall_clock` stamps the records; default: the system's clock.
  static Result<Journal> open(const std::filesystem::path& file, std::function<double()> wall_clock = {});
  /// Keeps the records in memory only: for dry runs and tests.
  static Journal in_memory(std::function<double()> wall_clock = {});
  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&& other) noexcept;
  ~Journal();

  /// What was there when it was opened; in memory: also what was appended since.
  const std::vector<Record>& records() const { return records_; }
  std::size_t dropped_bytes() const { return dropped_bytes_; }

  /// The record has reached the kernel when this returns (a kill of the pilot loses nothing; sync() for a power cut).
  /// Error: the disk is full or failing; then the file still ends with a whole record.
  Status append(const std::string& kind, const json::Value& payload);
  /// Nothing, or why the next append() may fail: space for the last words is kept in reserve, and this says when it is
  /// touched.
  Status healthy() const;
  /// Waits until the disk has what was appended.
  Status sync();
  /// Whether there is anything to sync().
  bool dirty() const { return dirty_; }

 private:
  Journal() = default;
  Status reserve();

  int fd_ = -1;
  bool in_memory_ = false;
  std::filesystem::path file_;
  std::function<double()> wall_clock_;
  std::vector<Record> records_;
  std::size_t dropped_bytes_ = 0;
  std::uint64_t next_sequence_ = 1;
  std::uint64_t size_ = 0;      ///< bytes of whole records
  std::uint64_t reserved_ = 0;  ///< bytes the file system has promised us
  bool dirty_ = false;          ///< appended to since the last sync()
  Status health_;
};

}  // namespace granary::pilot
