#include "pbm_solver/run.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <ctime>
#include <optional>

#include "common/json/io.hpp"
#include "common/log.hpp"
#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/model/simd/operations.hpp"
#include "pbm_solver/output/state_file.hpp"
#include "pbm_solver/output/summary.hpp"
#include "pbm_solver/parallel/rank_exchange.hpp"
#include "pbm_solver/time/simulation.hpp"

namespace granary::pbm {
namespace {

namespace fs = std::filesystem;

constexpr double kCheckpointEvery = 1.0;  // [s] of wall time
constexpr double kRoundOff = 1e-9;

volatile std::sig_atomic_t stop_asked = 0;

double wall_now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Output times are multiples of output_every, so that they do not depend on where a run was restarted.
double next_output(const PbmCase& c, double time) {
  const double next = (std::floor(time / c.output_every + kRoundOff) + 1.0) * c.output_every;
  return next >= c.end_time - kRoundOff * c.output_every ? c.end_time : next;
}

Status check_options(const RunOptions& options, const PbmCase& c, const Communicator& ranks) {
  if (ranks.size() > c.compartments.count)
    return Error{fmt::format(
        "{}: {} ranks for {} compartments: each rank needs at least one. Start fewer ranks with more --threads.",
        options.case_file.string(), ranks.size(), c.compartments.count)};
  std::error_code unknown;
  if (c.restart && fs::equivalent(c.restart->file, options.out, unknown))
    return Error{fmt::format("{}: --out is the file of /restart/file, whose states would be lost. Name another.",
                             options.out.string())};
  return {};
}

Result<Snapshot> read_start(const PbmCase& c, const fs::path& case_file) {
  const ClassGrid grid(c.grid);
  if (!c.restart) return initial_snapshot(c, grid);
  GRANARY_TRY(Snapshot start, read_restart(*c.restart, c, grid));
  if (start.time >= c.end_time)
    return Error{fmt::format("{}: /end_time is {:g} s, but the restart begins at {:g} s. Set a later end.",
                             case_file.string(), c.end_time, start.time)};
  return start;
}

/// What rank 0 writes. The other ranks have one too, which does nothing.
class Writer {
 public:
  static Result<Writer> open(const RunOptions& options, const PbmCase& c, const ClassGrid& grid,
                             const Communicator& ranks, double start) {
    Writer writer;
    writer.case_ = &c;
    writer.grid_ = &grid;
    if (!ranks.first()) return writer;
    const fs::path folder = options.out.parent_path();
    writer.checkpoint_ = folder / "checkpoint.h5";
    GRANARY_TRY(writer.states_, as_optional(StateFile::create(options.out, c, grid)));
    GRANARY_TRY(writer.progress_, as_optional(json::LineWriter::create(folder / "progress.jsonl")));
    GRANARY_CHECK(writer.progress_->append(progress_header(c, start, ranks.size(), options.threads)));
    return writer;
  }
  Status output(const Snapshot& snapshot, const Cost& cost) {
    if (!states_) return {};
    const Summary summary = summarize(snapshot, *case_, *grid_);
    GRANARY_CHECK(states_->append(snapshot, summary));
    return progress_->append(progress_line(snapshot, summary, cost));
  }
  Status checkpoint(const Snapshot& snapshot) const {
    return states_ ? write_checkpoint(checkpoint_, *case_, *grid_, snapshot) : Status{};
  }

 private:
  template <class T>
  static Result<std::optional<T>> as_optional(Result<T> made) {
    if (!made) return std::move(made).error();
    return std::optional<T>(std::move(made).value());
  }
  const PbmCase* case_ = nullptr;
  const ClassGrid* grid_ = nullptr;
  fs::path checkpoint_;
  std::optional<StateFile> states_;
  std::optional<json::LineWriter> progress_;
};

/// The run itself: outputs on time, checkpoints now and then, a stop when asked.
class Run {
 public:
  Run(Simulation& simulation, Writer& writer, const Communicator& ranks)
      : simulation_(&simulation), writer_(&writer), ranks_(&ranks), began_(wall_now()), last_checkpoint_(began_) {}

  Status to_the_end() {
    const PbmCase& c = simulation_->pbm_case();
    GRANARY_CHECK(output());
    while (simulation_->time() < c.end_time && !stopped_) {
      GRANARY_TRY(const bool reached,
                  simulation_->advance(next_output(c, simulation_->time()), [this] { return after_step(); }));
      GRANARY_CHECK(ranks_->agree(problem_));
      if (reached) GRANARY_CHECK(output());
    }
    return ranks_->agree(writer_->checkpoint(simulation_->snapshot()));
  }
  bool stopped() const { return stopped_ && simulation_->time() < simulation_->pbm_case().end_time; }
  Cost cost() const {
    const double cpu = static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
    return {wall_now() - began_, ranks_->sum(cpu), simulation_->work()};
  }

 private:
  Status output() {
    const Cost so_far = cost();
    return ranks_->agree(writer_->output(simulation_->snapshot(), so_far));
  }
  /// Whether to go on. All ranks hear of a signal to any of them, and of rank 0's clock.
  bool after_step() {
    std::array<double, 2> wishes{stop_asked ? 1.0 : 0.0,
                                 ranks_->first() && wall_now() - last_checkpoint_ >= kCheckpointEvery ? 1.0 : 0.0};
    ranks_->max(wishes);
    stopped_ = wishes[0] > 0.0;
    if (stopped_ || wishes[1] == 0.0) return !stopped_;
    problem_ = ranks_->agree(writer_->checkpoint(simulation_->snapshot()));
    last_checkpoint_ = wall_now();
    return problem_.has_value();
  }

  Simulation* simulation_;
  Writer* writer_;
  const Communicator* ranks_;
  double began_, last_checkpoint_;
  bool stopped_ = false;
  Status problem_;
};

json::Value report(const RunOptions& options, const Run& run, const Simulation& simulation) {
  const Cost cost = run.cost();
  return json::Value::object({{"ended", run.stopped() ? "stopped" : "done"},
                              {"time_s", simulation.time()},
                              {"wall_s", cost.wall},
                              {"cpu_s", cost.cpu},
                              {"steps", cost.work.steps},
                              {"rejected", cost.work.rejected},
                              {"implicit_steps", cost.work.implicit_steps},
                              {"rhs_evaluations", cost.work.rhs_evaluations},
                              {"instruction_set", simd::instruction_set()},
                              {"kernel_error", simulation.kernel_error()},
                              {"out", options.out.string()}});
}

}  // namespace

void install_stop_signals() {
  struct sigaction action = {};
  action.sa_handler = [](int) { stop_asked = 1; };
  action.sa_flags = SA_RESTART;
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGUSR1, &action, nullptr);
}

Result<json::Value> run_case(const RunOptions& options, const Communicator& ranks) {
  const auto prepared = [&]() -> Result<std::pair<PbmCase, Snapshot>> {
    GRANARY_TRY(const json::Value document, json::read_file(options.case_file));
    GRANARY_TRY(PbmCase c, read_case(document, options.case_file.string()));
    GRANARY_CHECK(check_options(options, c, ranks));
    GRANARY_TRY(Snapshot start, read_start(c, options.case_file));
    return std::pair(std::move(c), std::move(start));
  }();
  GRANARY_CHECK(ranks.agree(prepared ? Status{} : Status(prepared.error())));
  const auto& [c, start] = *prepared;

  RankExchange exchange(ranks, c.compartments.count);
  Simulation simulation(c, start, exchange, options.threads);
  auto writer = Writer::open(options, c, simulation.grid(), ranks, start.time);
  GRANARY_CHECK(ranks.agree(writer ? Status{} : Status(writer.error())));
  Run run(simulation, *writer, ranks);
  const Status ended = run.to_the_end();
  if (!ended) return ended.error();
  return report(options, run, simulation);
}

}  // namespace granary::pbm
