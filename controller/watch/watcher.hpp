// Looks at a run directory from outside and says what goes on in it: journal, files of the bursts, the pilot's answer.
// Never writes, never starts anything; the campaign does not notice.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "controller/watch/burst_files.hpp"
#include "controller/watch/estimation_files.hpp"
#include "controller/watch/history.hpp"
#include "controller/watch/journal_tail.hpp"
#include "controller/watch/view.hpp"

namespace granary::watch {

/// What the watcher asks others for.
struct Sources {
  /// As `granary status`: the living pilot's answer, or the journal's; with "alive".
  std::function<Result<json::Value>()> status;
  /// The campaign's jobs in the batch system: [{job, state, reason}]; asked at most every quarter of a minute.
  std::function<json::Value()> queue = [] { return json::Value::array(); };
  /// [s], any zero.
  std::function<double()> clock;
};

class Watcher {
 public:
  Watcher(std::filesystem::path dir, Sources sources);

  /// Whether there is a campaign at all: a campaign.json or a journal.
  bool anything_there() const;
  /// Reads what is new and tells how it stands.
  View look();

 private:
  void read_campaign();
  void ask_status();
  void ask_queue();

  void fill_tasks(View& view) const;
  void fill_coupling(View& view) const;
  void fill_phase(View& view) const;
  std::optional<Steadiness> steadiness() const;
  Exit exit_of_tasks() const;
  std::string headline(const View& view) const;
  std::string what_runs(const View& view) const;

  std::filesystem::path dir_;
  Sources sources_;
  JournalTail tail_;
  History history_;
  BurstFiles files_;
  EstimationFiles estimation_;
  json::Value campaign_;  ///< campaign.json; null before it is there
  json::Value status_, queue_;
  std::string status_problem_;
  std::uint64_t status_at_ = 0;  ///< records of the journal when a dead campaign's status was made
  double queue_asked_ = -1e9;
};

}  // namespace granary::watch
