// Bursts as folders of a run directory: decks, cases, tallies and states. Formats: docs/exchange_formats.md.
#pragma once

#include <filesystem>
#include <functional>

#include "controller/campaign/campaign.hpp"
#include "controller/coupling/exchange.hpp"
#include "controller/coupling/settings.hpp"
#include "controller/run/handover.hpp"

namespace granary::run {

class FileHandover final : public Handover {
 public:
  /// `dir` is the run directory, absolute. `programs` is the folder of granary-dem, granary-pbm and granary-monitor.
  FileHandover(const campaign::Campaign& campaign, std::filesystem::path dir, std::filesystem::path programs);

  Result<BurstTasks> prepare(const coupling::StartBurst& start) override;
  pilot::TaskSpec late_monitor(const coupling::BurstId& burst, int attempt) override;
  std::optional<double> clock(const coupling::BurstId& burst, const pilot::TaskEnd& program) override;
  Result<monitor::Verdict> verdict(const coupling::BurstId& burst, const pilot::TaskEnd& monitor) override;
  std::string last_words(const pilot::TaskEnd& program) override;
  Result<coupling::DemSummary> carry_dem(const coupling::Exchange& exchange) override;
  Result<coupling::PbmSummary> carry_pbm(const coupling::Exchange& exchange) override;

  /// A last word on the case of each PBM burst: what an estimation puts into it.
  using Adoption = std::function<json::Value(json::Value pbm_case, const coupling::StartBurst& start)>;
  void adopt_with(Adoption adoption) { adoption_ = std::move(adoption); }

  /// granary-pbm on the case.json of its folder, with the workflow's ranks and threads; without name and folder.
  pilot::TaskSpec pbm_task() const;
  /// The rates a DEM burst gave, measured anew from its tallies.
  Result<coupling::MeasuredRates> rates_of(const coupling::BurstId& dem_burst) const;
  /// What one that is still running has counted so far, its first windows too. Error: nothing yet.
  Result<coupling::MeasuredRates> rates_so_far(const coupling::BurstId& dem_burst) const;

 private:
  std::filesystem::path folder(const coupling::BurstId& burst) const;
  Result<pilot::TaskSpec> prepare_dem(const coupling::StartBurst& start) const;
  Result<pilot::TaskSpec> prepare_pbm(const coupling::StartBurst& start) const;
  pilot::TaskSpec monitor_task(const coupling::BurstId& burst, int attempt) const;
  Result<coupling::MeasuredRates> measured(const coupling::BurstId& dem_burst, double grace) const;
  Result<coupling::HoldUp> hold_up_for(const coupling::StartBurst& start) const;

  const campaign::Campaign* campaign_;
  std::filesystem::path dir_;
  std::filesystem::path programs_;
  Adoption adoption_;
};

/// The workflow's settings in the coupling's words.
coupling::Settings coupling_settings(const campaign::Campaign& campaign);

}  // namespace granary::run
