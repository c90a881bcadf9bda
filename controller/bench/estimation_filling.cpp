#include "controller/bench/estimation_filling.hpp"

#include <fmt/format.h>

#include <utility>

#include "common/files.hpp"
#include "pilot/launch/simulated_launcher.hpp"
#include "pilot/loop/virtual_loop.hpp"
#include "pilot/pilot.hpp"

namespace granary::bench {
namespace {

namespace fs = std::filesystem;
using json::Value;
using pilot::TaskSpec;

constexpr int kNodes = 4, kCoresOfNode = 64, kRounds = 4;
constexpr double kDem = 600.0, kPbm = 300.0, kFiller = 3.0;  // [s]

struct Split {
  int dem, pbm;
};

TaskSpec burst(int k, const Split& split) {
  TaskSpec task;
  task.name = fmt::format("{:04}-{}", k / 2 + 1, k % 2 == 0 ? "dem" : "pbm");
  task.command = {"simulated"};
  task.ranks = k % 2 == 0 ? split.dem : split.pbm;
  return task;
}

/// One campaign: each burst is submitted when the one before it has ended, as the coupling does.
class Campaign {
 public:
  Campaign(pilot::Pilot& pilot, const Split& split, bool filling) : pilot_(pilot), split_(split), filling_(filling) {}

  Status begin() {
    GRANARY_CHECK(submit(burst(0, split_)));
    return fill();
  }
  Status ended(const pilot::TaskEnd& end) {
    if (end.name.rfind("estimate", 0) == 0) {
      --fillers_;
      return fill();
    }
    if (++bursts_ < 2 * kRounds) return submit(burst(bursts_, split_));
    over_ = end.end;
    usage_ = pilot_.usage();
    pilot_.stop_all("the coupling is over");
    return {};
  }
  double over() const { return over_; }
  const pilot::Usage& usage() const { return usage_; }

 private:
  Status submit(TaskSpec task) {
    const auto id = pilot_.submit(std::move(task));
    return id ? Status{} : Status(id.error());
  }
  /// As many as the crew keeps: the cores and a few more.
  Status fill() {
    constexpr int kWanted = kNodes * kCoresOfNode * 9 / 8 + 1;
    while (filling_ && !pilot_.stopping() && fillers_ < kWanted) {
      TaskSpec task;
      task.name = fmt::format("estimate-{:06}", ++number_);
      task.command = {"simulated"};
      task.fill = true;
      GRANARY_CHECK(submit(std::move(task)));
      ++fillers_;
    }
    return {};
  }

  pilot::Pilot& pilot_;
  Split split_;
  bool filling_;
  int bursts_ = 0, fillers_ = 0, number_ = 0;
  double over_ = 0.0;
  pilot::Usage usage_;
};

struct Outcome {
  double makespan = 0.0;
  pilot::Usage usage;
};

Result<Outcome> simulate(const Split& split, bool filling, const fs::path& dir) {
  GRANARY_CHECK(make_folders(dir));
  pilot::VirtualLoop loop;
  pilot::SimulatedLauncher launcher(loop, [](const TaskSpec& task) {
    return pilot::SimulatedRun{task.fill ? kFiller : task.name.ends_with("dem") ? kDem : kPbm};
  });
  GRANARY_TRY(pilot::Journal journal, pilot::Journal::open(dir / "journal.jsonl", [&] { return loop.wall_time(); }));
  const pilot::Machine machine = pilot::stated_machine(kNodes, kCoresOfNode);
  GRANARY_TRY(const auto pilot,
              pilot::Pilot::open({.dir = dir, .machine = machine, .sync_every = 0.0}, loop, launcher, journal));
  Campaign campaign(*pilot, split, filling);
  Status failed;
  pilot->on_end([&](const pilot::TaskEnd& end) {
    if (failed) failed = campaign.ended(end);
    if (!failed) loop.stop();
  });
  pilot->on_idle([&] { loop.stop(); });
  GRANARY_CHECK(campaign.begin());
  loop.run();
  GRANARY_CHECK(failed);
  return Outcome{campaign.over(), campaign.usage()};
}

}  // namespace

Result<Value> simulate_filling(const fs::path& dir) {
  Value rows = Value::array();
  for (const Split& split : {Split{16, 1}, Split{64, 4}, Split{128, 8}, Split{256, 1}, Split{256, 16}}) {
    const std::string name = fmt::format("{}-{}", split.dem, split.pbm);
    GRANARY_TRY(const Outcome off, simulate(split, false, dir / (name + "-off")));
    GRANARY_TRY(const Outcome on, simulate(split, true, dir / (name + "-on")));
    rows.push(Value::object({{"dem_cores", split.dem},
                             {"pbm_cores", split.pbm},
                             {"core_use_off", off.usage.busy / off.usage.total},
                             {"core_use_on", on.usage.busy / on.usage.total},
                             {"slowdown", on.makespan / off.makespan - 1.0},
                             {"evaluation_core_s", on.usage.fillers}}));
  }
  return rows;
}

}  // namespace granary::bench
