#include "pbm_solver/bench/measure.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

#include "common/math/percentile.hpp"

namespace granary::pbm::bench {

double thread_cpu() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double wall_clock() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<Timing> time_in_turn(const std::vector<Contender>& contenders, int rounds, double least_sample) {
  const auto sample = [](const Contender& one, int evaluations) {
    const double began = thread_cpu();
    for (int k = 0; k < evaluations; ++k) one.evaluate();
    return (thread_cpu() - began) / evaluations;
  };
  std::vector<std::vector<double>> seconds(contenders.size());
  std::vector<int> evaluations, most_rounds;
  for (std::size_t c = 0; c < contenders.size(); ++c) {
    double first = std::max(sample(contenders[c], 1), 1e-9);
    if (first < least_sample) first = std::max(sample(contenders[c], 1), 1e-9);  // the very first pays for its memory
    evaluations.push_back(static_cast<int>(std::ceil(std::max(least_sample / first, 1.0))));
    most_rounds.push_back(
        static_cast<int>(std::min<double>(rounds, contenders[c].most_cpu / (first * evaluations[c]))));
    if (most_rounds[c] < 2) seconds[c].push_back(first);
  }
  for (int round = 0; round < rounds; ++round)
    for (std::size_t c = 0; c < contenders.size(); ++c)
      if (static_cast<int>(seconds[c].size()) < most_rounds[c])
        seconds[c].push_back(sample(contenders[c], evaluations[c]));
  std::vector<Timing> timings;
  for (const std::vector<double>& one : seconds) timings.push_back({median(one), static_cast<int>(one.size())});
  return timings;
}

}  // namespace granary::pbm::bench
