// Fillers that only cost time: what a dry run puts where an estimation would be at work.
#pragma once

#include "controller/run/companion.hpp"
#include "pilot/pilot.hpp"

namespace granary::run {

class SimulatedEstimation final : public Companion {
 public:
  /// `first_rates`: how long the first DEM burst runs before it has counted anything [s].
  SimulatedEstimation(pilot::Pilot& pilot, pilot::EventLoop& loop, double first_rates)
      : pilot_(pilot), loop_(loop), first_rates_(first_rates) {}

  Status begin(const coupling::State&) override { return {}; }
  void told(const coupling::Event& event, const coupling::State& state) override;
  void task_ended(const pilot::TaskEnd& end) override;
  void finish(const coupling::State& state, std::function<void()> done) override;

 private:
  void submit();

  pilot::Pilot& pilot_;
  pilot::EventLoop& loop_;
  double first_rates_;
  int submitted_ = 0, open_ = 0;
  bool over_ = false;
};

}  // namespace granary::run
