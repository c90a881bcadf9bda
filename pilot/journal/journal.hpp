// The campaign's memory: one line of JSON a record, appended before what it tells of is done. docs/journal_format.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <future>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "pilot/journal/line.hpp"

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
  /// In memory, beginning with what a file holds; the file is never changed.
  static Result<Journal> copy_of(const std::filesystem::path& file);
  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&& other) noexcept;
  ~Journal();

  std::uint64_t n_records() const { return next_sequence_ - 1; }
  /// When the first record was written [s since 1970-01-01 UTC]; nothing while there is none.
  std::optional<double> first_wall_time() const { return first_wall_time_; }
  std::size_t dropped_bytes() const { return dropped_bytes_; }
  /// Reads all records again, one after the other, in bounded memory. Error: of reading, or the first of `fn`.
  Status for_each(const std::function<Status(const Line&)>& fn) const;
  /// Those whose kind begins with `kind`.
  std::vector<Record> records(std::string_view kind = "") const;

  /// Adds a record that flush() writes, with all others since the last flush. `payload`: JSON.
  void add(std::string_view kind, std::string_view payload);
  /// What was added has reached the kernel when this returns (a kill of the pilot loses nothing; sync() for a power
  /// cut). Error: the disk is full or failing; then the file still ends with a whole record.
  Status flush();
  /// add() and flush().
  Status append(const std::string& kind, const json::Value& payload);
  /// Nothing, or why the next flush() may fail: space for the last words is kept in reserve, and this says when it is
  /// touched.
  Status healthy() const;
  /// Waits until the disk has what was flushed.
  Status sync();
  /// Likewise, but beside us: a slow disk must hold up nobody. Error: that of an earlier call, or of a write since.
  Status sync_beside();
  /// Whether there is anything to sync().
  bool dirty() const { return dirty_; }

  /// Replaces the file's records by those that `write` adds: written beside it, then renamed over it, so that a kill at
  /// any moment leaves the old file or the new one. `write` gets a journal to add() to.
  Status rewrite(const std::function<void(Journal&)>& write);
  /// Stamps what add() is given from now on; nothing: the clock's time.
  void stamp_with(std::optional<double> wall_time) { stamp_ = wall_time; }

 private:
  Journal() = default;
  Status reserve();
  Status write_out();

  int fd_ = -1;
  std::filesystem::path file_;
  std::function<double()> wall_clock_;
  std::optional<double> stamp_, first_wall_time_;
  std::string buffer_;  ///< lines to flush; in memory: all of them
  std::size_t dropped_bytes_ = 0;
  std::uint64_t next_sequence_ = 1;
  std::uint64_t buffered_ = 0;  ///< lines to flush
  std::uint64_t size_ = 0;      ///< bytes of whole records in the file
  std::uint64_t reserved_ = 0;  ///< bytes the file system has promised us
  bool dirty_ = false;          ///< flushed to since the last sync()
  Status health_;
  std::future<int> syncing_;  ///< 0, or what went wrong
};

}  // namespace granary::pilot
