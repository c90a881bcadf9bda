#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <optional>

#include "common/files.hpp"
#include "common/math/percentile.hpp"
#include "controller/bench/dem_cases.hpp"
#include "controller/bench/dem_deck.hpp"
#include "controller/bench/dem_run.hpp"
#include "controller/bench/dem_speed.hpp"
#include "dem_templates/render/automatic.hpp"

namespace granary::bench {
namespace {

namespace fs = std::filesystem;
using json::Value;

constexpr double kProcess = 10.0;  // [s]

/// Of the pair forces' time, by the tally's own clock, as it says at the end of a run [%]; 0 if it says nothing.
double said_share(const std::string& printed) {
  double seconds = 0.0, share = 0.0;
  const auto at = printed.rfind("granary/tally: ");
  return at != std::string::npos &&
                 std::sscanf(printed.c_str() + at, "granary/tally: %lf s, %lf %%", &seconds, &share) == 2
             ? share
             : 0.0;
}

/// What the tally adds to a step, over the time of the pair forces in it.
Result<Value> tally_overhead(Effort effort, const fs::path& scratch) {
  dem::DemCase c = mixer_case({{0.004, 2300}});
  c.tally.every = dem::automatic_tally_every(c);  // as a workflow has it that does not say
  GRANARY_TRY(const State state, settled_state(c, 3, scratch / "overhead-tally"));
  std::vector<double> bare, tallied, pair, own;
  constexpr long steps = 8000;
  for (int repeat = 0; repeat < by_effort(effort, 7, 11, 15); ++repeat)
    for (const bool with : {false, true}) {
      TimingDeck deck{dem::Walls::granary, 0.003, 200, steps, with ? static_cast<int>(steps / 2000) : 0};  // of 10 ms
      GRANARY_TRY(const std::string text, timing_deck(c, deck));
      GRANARY_CHECK(write_text_atomically(state.folder / "in.overhead", text));
      GRANARY_TRY(const DemRun run, run_dem(granary_dem(), state.folder, "in.overhead"));
      (with ? tallied : bare).push_back(run.loops.back().ms_per_step());
      if (with) own.push_back(1e-2 * said_share(run.printed));
      if (!with) pair.push_back(1e3 * run.loops.back().pair_seconds / static_cast<double>(steps));
    }
  // The least of the repeats: what others do on the machine only ever adds, and more than the tally does.
  const auto least = [](const std::vector<double>& all) { return *std::min_element(all.begin(), all.end()); };
  const double more = least(tallied) - least(bare), by_its_clock = median(own);
  return Value::object({{"particles", static_cast<std::int64_t>(state.particles)},
                        {"every_steps", c.tally.every},
                        {"without_ms_per_step", least(bare)},
                        {"with_ms_per_step", least(tallied)},
                        {"pair_ms_per_step", least(pair)},
                        {"share_of_pair_time", more / least(pair)},
                        {"share_of_pair_time_by_its_clock", by_its_clock},
                        {"share_of_step", more / least(bare)},
                        {"without_ms_all", bare},
                        {"with_ms_all", tallied}});
}

/// Wall time of a burst from a restart that is none of its steps: start, reading, resize, lists, writing the state.
Result<Value> restart_overhead(Effort effort, const fs::path& scratch) {
  dem::DemCase c = mixer_case({{0.004, 2300}});
  c.settle_time = c.duration = c.tally.window = 0.01;
  const fs::path first = scratch / "overhead-burst", second = scratch / "overhead-next";
  GRANARY_TRY(const Burst before, run_burst(c, first));
  c.restart = fs::absolute(first / "restart.liggghts");
  std::vector<double> all;
  for (int repeat = 0; repeat < by_effort(effort, 2, 3, 7); ++repeat) {
    GRANARY_TRY(const Burst next, run_burst(c, second));
    double stepping = 0.0;
    for (const Loop& loop : next.run.loops) stepping += loop.seconds;
    all.push_back(next.run.wall_s - stepping);
  }
  return Value::object({{"particles", 2300}, {"seconds", median(all)}, {"seconds_all", all}});
}

/// Ten seconds of the mixer on one core, with the steps that "auto" takes: a stretch, or all of them. The outlet is
/// closed, so that the hold-up stays: at 15 kg/h the mixer would empty itself of nine tenths of it on the way.
Result<Value> process(Effort effort, const fs::path& scratch) {
  dem::DemCase c = ten_seconds_mixer();
  c.time_step = dem::automatic_time_step(c);
  c.duration = by_effort(effort, 0.15, 0.45, kProcess);
  GRANARY_TRY(const Burst burst, run_burst(c, scratch / "process"));
  const Loop& loop = burst.run.loops.back();
  const double measured = static_cast<double>(loop.steps) * c.time_step;
  return Value::object({{"process_s", kProcess},
                        {"particles_at_start", 2300},
                        {"particles_at_end", static_cast<std::int64_t>(loop.particles)},
                        {"time_step_s", c.time_step},
                        {"measured_s", measured},
                        {"ms_per_step", loop.ms_per_step()},
                        {"wall_s", loop.seconds / measured * kProcess},
                        {"is_extrapolated", measured < 0.99 * kProcess}});
}

}  // namespace

Result<Value> overheads(Effort effort, const fs::path& scratch, const Say& say) {
  Value all = Value::object();
  say("what the tally costs");
  GRANARY_TRY(const Value tally, tally_overhead(effort, scratch));
  say("what a restart costs");
  GRANARY_TRY(const Value restart, restart_overhead(effort, scratch));
  say(effort == Effort::full ? "ten seconds of the mixer with its hold-up" : "a stretch of the mixer with its hold-up");
  GRANARY_TRY(const Value ten, process(effort, scratch));
  return all.set("tally_overhead", tally).set("restart_overhead", restart).set("process", ten);
}

}  // namespace granary::bench
