#include "controller/bench/dem_speed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "common/math/percentile.hpp"
#include "controller/bench/dem_cases.hpp"
#include "controller/bench/dem_deck.hpp"
#include "controller/bench/dem_run.hpp"
#include "controller/bench/dem_tallied.hpp"
#include "dem_templates/geometry/machine.hpp"
#include "dem_templates/geometry/mesh.hpp"
#include "dem_templates/geometry/stl.hpp"
#include "pilot/schedule/machine.hpp"

namespace granary::bench {
namespace {

namespace fs = std::filesystem;
using json::Value;

struct SpeedCase {
  std::string name;
  dem::DemCase dem;
  std::vector<int> ranks{1};
  long stock_steps, granary_steps;  ///< of a repeat: about a second each
  long tallied_steps;               ///< for rates and speeds; 0: not looked at
  int split = 1;                    ///< each triangle of vessel and impeller in split^2: the same shape
};

constexpr double kTurn = 0.03;  // 2000 rpm
// 2000 rad/s, the speed of the published decks, as a whole number of steps a turn: 2001 rad/s.
constexpr double kFastTurn = 628 * 5e-6;

std::vector<SpeedCase> speed_cases(Effort effort) {
  const double k = by_effort(effort, 0.5, 1.0, 3.0);
  const auto steps = [k](long n) { return static_cast<long>(static_cast<double>(n) * k); };
  const Fill usual{{0.004, 2300}}, many{{0.00245, 10000}};
  return {{"cm5, 2000 rpm", mixer_case(usual, kTurn, 3), {1}, steps(1000), steps(4000), steps(12000)},
          {"cm5, 2000 rad/s", mixer_case(usual, kFastTurn, 3), {1}, steps(300), steps(1500), steps(3000)},
          {"cm5, 16 times the triangles", mixer_case(usual, kTurn, 3), {1}, steps(150), steps(4000), 0, 4},
          {"cm5, 7 times, rounder", mixer_case(usual, kTurn, 8), {1}, steps(150), steps(4000), 0},
          {"cm5, 10 times, rounder", mixer_case(usual, kTurn, 10), {1}, steps(150), steps(4000), 0},
          {"cm5, 10 000 particles", mixer_case(many, kTurn, 3), {1, 2}, steps(300), steps(1200), 0}};
}

/// One program on one state, many times.
struct Runner {
  const SpeedCase& one;
  const State& state;

  std::string program(dem::Walls walls) const { return walls == dem::Walls::stock ? "liggghts" : granary_dem(); }

  Result<DemRun> run(const TimingDeck& deck, int ranks) const {
    dem::DemCase c = one.dem;
    c.ranks = ranks;
    GRANARY_TRY(const std::string text, timing_deck(c, deck));
    const std::string input = deck.walls == dem::Walls::stock ? "in.stock" : "in.granary";
    GRANARY_CHECK(write_text_atomically(state.folder / input, text));
    return run_dem(program(deck.walls), state.folder, input, ranks);
  }
};

/// The skin with which a stock step takes least, of some; each tried for a short stretch.
Result<double> best_stock_skin(const Runner& runner, Value& row) {
  const double d = runner.one.dem.population.front().diameter.front();
  double best = d, least = 1e300;
  Value tried = Value::array();
  for (const double share : {0.5, 0.75, 1.0, 1.5, 2.0}) {
    TimingDeck deck{dem::Walls::stock, share * d, 50, runner.one.stock_steps / 3};
    GRANARY_TRY(const DemRun run, runner.run(deck, 1));
    const double ms = run.loops.back().ms_per_step();
    tried.push(Value::object({{"skin_m", share * d}, {"ms_per_step", ms}}));
    if (ms < least) least = ms, best = share * d;
  }
  row.set("stock_skins_tried", tried);
  return best;
}

std::int64_t impeller_triangles(const SpeedCase& one) {
  const dem::Machine& machine = one.dem.machine;
  return static_cast<std::int64_t>(dem::mixer_impeller(machine.mixer, machine.refinement).triangle.size()) * one.split *
         one.split;
}

/// Gives the case its own meshes, split, as files.
Status split_triangles(SpeedCase& one, const fs::path& folder) {
  if (one.split == 1) return {};
  dem::Machine& machine = one.dem.machine;
  GRANARY_CHECK(make_folders(folder));
  const auto write = [&](const char* name, const dem::Mesh& mesh) {
    return write_text_atomically(folder / name, dem::stl_text(dem::refine(mesh, one.split), name));
  };
  GRANARY_CHECK(write("shell.stl", dem::mixer_shell(machine.mixer, machine.refinement)));
  GRANARY_CHECK(write("impeller.stl", dem::mixer_impeller(machine.mixer, machine.refinement)));
  machine.shell_stl = folder / "shell.stl";
  machine.impeller_stl = folder / "impeller.stl";
  return {};
}

/// Rates and speeds of both kinds of walls from the same state, each by granary-dem with its tally.
Status add_differences(const Runner& runner, double stock_skin, Value& row) {
  std::array<std::vector<Measured>, 2> measured;
  const auto measure = [&](std::size_t k) -> Status {
    TimingDeck deck{k == 0 ? dem::Walls::stock : dem::Walls::granary, std::nullopt, 200, runner.one.tallied_steps, 10};
    if (k == 0) deck.skin = stock_skin;
    const fs::path folder = runner.state.folder / (k == 0 ? "tallied_stock" : "tallied_granary");
    std::error_code failed;
    GRANARY_CHECK(make_folders(folder));
    fs::copy(runner.state.folder / "meshes", folder / "meshes", failed);
    fs::copy(runner.state.folder / "state.data", folder / "state.data", failed);
    GRANARY_TRY(const std::string text, timing_deck(runner.one.dem, deck));
    GRANARY_CHECK(write_text_atomically(folder / "in.tallied", text));
    GRANARY_TRY(const DemRun run, run_dem(granary_dem(), folder, "in.tallied"));
    GRANARY_TRY(const auto lines, json::read_lines(folder / "tallies.jsonl"));
    measured[k] = quantities({lines}, 1);
    return {};
  };
  GRANARY_CHECK(at_once(2, measure));
  const auto all = differences(measured[0], measured[1]);
  const auto put = [&](const char* name, const char* key, const char* error_key) {
    for (const Difference& d : all)
      if (d.name == name) row.set(key, d.relative()).set(error_key, d.relative_error());
  };
  put("collisions", "collision_rate_difference", "statistical_error");
  put("impact speed", "impact_speed_difference", "impact_speed_statistical_error");
  put("impacts", "impact_rate_difference", "impact_rate_statistical_error");
  return {};
}

/// The row of a case for each number of ranks, stock and ours in turn.
Result<Value> rows_of(const SpeedCase& one, Effort effort, const fs::path& scratch, const Say& say) {
  say(fmt::format("{}: its settled state", one.name));
  GRANARY_TRY(const State state, settled_state(one.dem, 3, scratch / fmt::format("speed-{}", fingerprint(one.name))));
  const Runner runner{one, state};
  Value common = Value::object({{"case", one.name},
                                {"particles", static_cast<std::int64_t>(state.particles)},
                                {"impeller_triangles", impeller_triangles(one)},
                                {"time_step_s", one.dem.time_step},
                                {"load", load_of_machine()}});
  say(fmt::format("{}: the best skin for stock LIGGGHTS", one.name));
  const auto skin = best_stock_skin(runner, common);
  // Stock LIGGGHTS refuses our finest meshes: then the row is ours alone, and says so.
  if (skin)
    common.set("stock_skin_m", *skin);
  else
    common.set("stock_failed", skin.error().message);

  const int repeats = by_effort(effort, 2, 3, 7);
  std::map<int, std::array<std::vector<double>, 2>> ms;
  std::map<int, std::array<long, 2>> left;
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (const int ranks : one.ranks) {
      say(fmt::format("{}: {} of {}, {} rank{}", one.name, repeat + 1, repeats, ranks, ranks > 1 ? "s" : ""));
      for (const auto walls : {dem::Walls::stock, dem::Walls::granary}) {
        const bool stock = walls == dem::Walls::stock;
        if (stock && !skin) continue;
        TimingDeck deck{walls, std::nullopt, 200, stock ? one.stock_steps : one.granary_steps};
        if (stock) deck.skin = *skin;
        GRANARY_TRY(const DemRun run, runner.run(deck, ranks));
        ms[ranks][stock ? 0 : 1].push_back(run.loops.back().ms_per_step());
        left[ranks][stock ? 0 : 1] = run.loops.back().particles;
      }
    }
  if (one.tallied_steps > 0 && skin) {
    say(fmt::format("{}: rates and speeds of both", one.name));
    GRANARY_CHECK(add_differences(runner, *skin, common));
  }
  Value rows = Value::array();
  for (const int ranks : one.ranks) {
    const double stock = median(ms[ranks][0]), granary = median(ms[ranks][1]);
    Value row = common;
    row.set("ranks", ranks)
        .set("stock_ms_per_step", skin ? Value(stock) : Value())
        .set("granary_ms_per_step", granary)
        .set("ratio", skin ? Value(stock / granary) : Value())
        .set("stock_ms_all", ms[ranks][0])
        .set("granary_ms_all", ms[ranks][1])
        .set("granary_particles_at_end", static_cast<std::int64_t>(left[ranks][1]));
    if (skin) row.set("stock_particles_at_end", static_cast<std::int64_t>(left[ranks][0]));
    if (ranks > 1) row.set("granary_over_one_rank", median(ms[1][1]) / granary);
    if (ranks > 1 && skin) row.set("stock_over_one_rank", median(ms[1][0]) / stock);
    say(skin ? fmt::format("{}: {:.3f} ms a step, ours {:.4f} ms: {:.1f}x", one.name, stock, granary, stock / granary)
             : fmt::format("{}: ours {:.4f} ms; stock LIGGGHTS fails", one.name, granary));
    rows.push(row);
  }
  return rows;
}

}  // namespace

Result<Value> speed_rows(Effort effort, const fs::path& scratch, const Say& say) {
  GRANARY_TRY(const pilot::Machine machine, pilot::local_machine());
  Value rows = Value::array();
  for (SpeedCase& one : speed_cases(effort)) {
    std::erase_if(one.ranks, [&](int ranks) { return ranks > machine.n_cores(); });
    GRANARY_CHECK(split_triangles(one, scratch / fmt::format("meshes-{}", fingerprint(one.name))));
    GRANARY_TRY(const Value some, rows_of(one, effort, scratch, say));
    for (const Value& row : some.items()) rows.push(row);
  }
  return rows;
}

}  // namespace granary::bench
