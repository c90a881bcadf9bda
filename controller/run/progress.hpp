// What a person sees while a campaign runs: a line at each switch, and how far the running burst is. All on stderr.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "common/json/io.hpp"
#include "controller/run/campaign_run.hpp"

namespace granary::run {

class Progress {
 public:
  /// `dir` is the run directory; empty (a dry run): nothing but the switches. `quiet`: nothing at all.
  Progress(pilot::EventLoop& loop, std::filesystem::path dir, bool quiet);

  /// To give to a CampaignRun.
  Watcher watcher();
  /// Ends the line being rewritten.
  void finish();

 private:
  void event(const coupling::Event& event);
  void action(const coupling::Action& action);
  void say(const std::string& line);
  void tick();
  std::string burst_progress();

  pilot::EventLoop& loop_;
  std::filesystem::path dir_;
  bool quiet_;
  bool terminal_;
  bool line_open_ = false;  ///< a rewritten line stands unfinished
  double last_plain_ = 0.0;
  std::optional<coupling::StartBurst> running_;
  std::unique_ptr<json::LineReader> reader_;
  json::Value last_;
  pilot::TimerId timer_ = pilot::TimerId::none;
};

}  // namespace granary::run
