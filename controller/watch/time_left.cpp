#include "controller/watch/time_left.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "controller/watch/words.hpp"

namespace granary::watch {

namespace {

constexpr int kRoundsToAverage = 3;

/// The mean of the last whole rounds.
struct Round {
  int n = 0;  ///< averaged over
  double wall = 0.0, process = 0.0;
  double began = 0.0;  ///< the current round, or where it will [pilot time, s]
};

Round mean_round(const View& view) {
  std::vector<Burst> all = view.bursts;
  if (view.burst) all.push_back(*view.burst);
  std::vector<double> starts;         // pilot time of each round's first burst
  std::vector<double> ends, process;  // of each round's PBM burst, if it is over
  for (const Burst& burst : all) {
    if (starts.empty() || burst.dem) starts.push_back(burst.pilot_start);
    if (burst.dem || std::isnan(burst.end) || std::isnan(burst.pilot_end)) continue;
    ends.push_back(burst.pilot_end);
    process.push_back(burst.end - burst.start);
  }
  Round mean;
  mean.n = std::min<int>(kRoundsToAverage, static_cast<int>(std::min(starts.size(), ends.size())));
  for (int k = 1; k <= mean.n; ++k) {
    const std::size_t round = ends.size() - static_cast<std::size_t>(k);
    mean.wall += (ends[round] - starts[round]) / mean.n;
    mean.process += process[round] / mean.n;
  }
  mean.began = starts.size() > ends.size() ? starts.back() : ends.empty() ? 0.0 : ends.back();
  return mean;
}

}  // namespace

std::optional<TimeLeft> time_left_coupled(const View& view, double longest_dem_burst, double now) {
  if (view.mode != "two-way") {
    if (!view.burst || view.burst->dem || !(view.burst_time > view.burst->start)) return std::nullopt;
    const double wall = now - view.burst->pilot_start;
    const double left = wall * (view.process_end - view.burst_time) / (view.burst_time - view.burst->start);
    return TimeLeft{
        left, left,
        fmt::format("{:.3g} s of process time took {}", view.burst_time - view.burst->start, duration(wall))};
  }
  const Round round = mean_round(view);
  if (round.n == 0 || !view.steadiness || !(round.process > 0.0)) return std::nullopt;
  const Steadiness& steady = *view.steadiness;
  const double quiet_missing = std::max(0.0, steady.window - steady.quiet_time);
  const double for_window = longest_dem_burst > 0.0 ? std::ceil(quiet_missing / longest_dem_burst - 1e-9) : 0.0;
  const double for_process = std::ceil((view.process_end - view.process_time) / round.process - 1e-9);
  const double most = std::max(1.0, std::min<double>(for_process, steady.most_rounds - steady.rounds));
  const double least =
      std::min(most, std::max({1.0, static_cast<double>(steady.least_rounds - steady.rounds), for_window}));
  const double gone = now - round.began;
  const auto after = [&](double rounds) { return std::max(0.0, rounds * round.wall - gone); };
  return TimeLeft{after(least), after(most),
                  fmt::format("{} a round (mean of {}): {:.0f} to steady at the earliest, {:.0f} to the end of all",
                              duration(round.wall), round.n, least, most)};
}

std::optional<TimeLeft> time_left_tasks(std::int64_t ended, std::int64_t left, double now) {
  if (ended < 3 || left <= 0 || !(now > 0.0)) return std::nullopt;
  const double seconds = now * static_cast<double>(left) / static_cast<double>(ended);
  return TimeLeft{seconds, seconds, fmt::format("{} ended in {}; {} left at that rate", ended, duration(now), left)};
}

}  // namespace granary::watch
