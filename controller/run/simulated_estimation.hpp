// Fillers that only cost time: what a dry run puts where an estimation would be at work.
#pragma once

#include "controller/run/companion.hpp"
#include "pilot/pilot.hpp"

namespace granary::run {

class SimulatedEstimation final : public Companion {
 public:
  explicit SimulatedEstimation(pilot::Pilot& pilot) : pilot_(pilot) {}

  Status begin(const coupling::State&) override { return {}; }
  void told(const coupling::Event& event, const coupling::State& state) override;
  void task_ended(const pilot::TaskEnd& end) override;
  void finish(const coupling::State& state, std::function<void()> done) override;

 private:
  void submit();

  pilot::Pilot& pilot_;
  int submitted_ = 0, open_ = 0;
  bool over_ = false;
};

}  // namespace granary::run
