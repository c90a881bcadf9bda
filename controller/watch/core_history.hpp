// Busy cores over time, by kind of task, in slices that double as the campaign grows: bounded, however long it runs.
#pragma once

#include "controller/watch/view.hpp"

namespace granary::watch {

class CoreSeconds {
 public:
  /// `cores` cores were busy with a task of this kind from `start` to `end` (pilot time) [s].
  void add(const std::string& kind, double start, double end, int cores);
  /// Mean busy cores from 0 to `now`; the last slice counts only as far as it has come.
  CoreHistory history(double now) const;

 private:
  void widen();

  double slice_ = 0.25;                                               ///< [s]
  std::vector<std::pair<std::string, std::vector<double>>> seconds_;  ///< core seconds in each slice
};

}  // namespace granary::watch
