// The estimation of a coupled campaign: idle cores work at it from the first rates on, those that the first DEM burst
// counts while it still runs; each DEM burst that is over makes it a new problem, PBM bursts may adopt what it knows,
// and once the coupling is over the balance runs again with its result. What to try is controller/estimation's; who
// runs where, the pilot's. docs/estimation.md#in-a-coupled-campaign
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "controller/campaign/campaign.hpp"
#include "controller/estimation/crew.hpp"
#include "controller/estimation/problem_of.hpp"
#include "controller/run/companion.hpp"
#include "controller/run/file_handover.hpp"
#include "pilot/journal/journal.hpp"
#include "pilot/pilot.hpp"

namespace granary::run {

class CampaignEstimation final : public Companion {
 public:
  /// All must outlive it. `campaign` has an estimation; `dir` is the run directory, absolute; `programs` the folder of
  /// granary-pbm. `note` tells people.
  CampaignEstimation(const campaign::Campaign& campaign, std::filesystem::path dir, std::filesystem::path programs,
                     FileHandover& handover, pilot::Pilot& pilot, pilot::EventLoop& loop, pilot::Journal& journal,
                     std::function<void(const std::string&)> note);

  Status begin(const coupling::State& state) override;
  void told(const coupling::Event& event, const coupling::State& state) override;
  void task_ended(const pilot::TaskEnd& end) override;
  void finish(const coupling::State& state, std::function<void()> done) override;

  /// A PBM case as its burst is to run it: with the best parameters known by now, where the workflow adopts
  /// continuously. Journals that it does ("estimation.adopted").
  json::Value adopted(json::Value pbm_case, const coupling::StartBurst& start);

  /// What `granary status` shows.
  json::Value status() const { return crew_.status(); }

 private:
  Result<std::vector<estimating::Stretch>> history(const coupling::State& state);
  void await_rates(const coupling::BurstId& dem_burst);
  Status work_on(const std::vector<estimating::Stretch>& stretches);
  void submit_fillers();
  void stop_fillers(const std::string& reason);
  void give_up(const Error& error);
  std::optional<estimation::Fitted> known_best() const;
  Status start_final_run(const coupling::State& state);

  const campaign::Campaign& campaign_;
  std::filesystem::path dir_, programs_;
  FileHandover& handover_;
  pilot::Pilot& pilot_;
  pilot::EventLoop& loop_;
  pilot::Journal& journal_;
  std::function<void(const std::string&)> note_;
  estimating::Crew crew_;
  bool given_up_ = false;
  pilot::TimerId awaiting_ = pilot::TimerId::none;  ///< of the next look for rates
  std::optional<estimation::Fitted> earlier_best_;  ///< of the last version before this one that was worked at enough
  std::map<int, pbm::DemRates> rates_;              ///< of each round's DEM burst
  std::set<std::string> fillers_;                   ///< submitted and not ended
  std::set<std::string> final_tasks_;               ///< likewise, of the final run
  std::function<void()> done_;                      ///< once the final run is over
};

}  // namespace granary::run
