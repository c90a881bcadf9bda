// Clocks and timings. What is timed is its callers' business.
#pragma once

#include <functional>
#include <vector>

namespace granary::pbm::bench {

/// CPU time of this thread [s]: what other programs on the machine take is not in it.
double thread_cpu();
double wall_clock();  ///< [s]

/// Something to be timed: one call is one evaluation.
struct Contender {
  std::function<void()> evaluate;
  double most_cpu = 1e300;  ///< of all its rounds; one evaluation is made in any case [s]
};

/// One contender's result.
struct Timing {
  double seconds = 0.0;  ///< of one evaluation: median over the rounds of thread CPU time
  int rounds = 0;
};

/// Times the contenders in turn, round by round, so that a busy spell of the machine meets all of them. A round of a
/// fast one is as many evaluations as fill `least_sample` seconds: a run evaluates thousands in a row, so the first
/// one, with what the contender before left in the caches, must not weigh. First evaluations warm up and do not count,
/// unless they take so long that there is only one.
std::vector<Timing> time_in_turn(const std::vector<Contender>& contenders, int rounds, double least_sample = 1e-2);

}  // namespace granary::pbm::bench
