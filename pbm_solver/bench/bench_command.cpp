#include "pbm_solver/bench/bench_command.hpp"

#include <cstdio>

#include "common/json/io.hpp"
#include "pbm_solver/bench/rhs_bench.hpp"
#include "pbm_solver/bench/row_bench.hpp"
#include "pbm_solver/bench/time_error.hpp"
#include "pbm_solver/bench/work_precision.hpp"
#include "pbm_solver/evaluate/twin.hpp"
#include "pbm_solver/evaluate/twin_bench.hpp"

namespace granary::pbm {
namespace {

int run_row(const BenchOptions& options) {
  const Communicator ranks;
  const auto timings = bench::row_timings(ranks, options.threads, options.seconds);
  if (!timings) {
    if (ranks.first()) std::fprintf(stderr, "granary-pbm: %s\n", timings.error().message.c_str());
    return static_cast<int>(timings.error().exit);
  }
  if (ranks.first()) std::printf("%s\n", json::dump(*timings, 1).c_str());
  return 0;
}

json::Value run_twins(const BenchOptions& options) {
  TwinBench twins;
  if (options.seeds > 0) twins.seeds = options.seeds;
  if (!options.parameters.empty()) twins.parameters = options.parameters;
  twins.methods = options.methods;
  if (options.product) return json::Value::object({{"product", bench_product_twin(twins)}});
  if (!options.write) return bench_twins(twins);
  const Twin twin = make_twin(twins.parameters.front(), 1);
  return json::Value::object({{"problem", estimation::to_json(twin.problem)}, {"truth", twin.truth}});
}

json::Value run_part(const std::string& part, bench::Effort effort) {
  if (part == "rhs") return bench::rhs_timings(effort);
  if (part == "work-precision") return bench::work_precision(effort);
  if (part == "temporal") return bench::time_errors(effort);
  return bench::published_run(effort);
}

}  // namespace

CLI::App* add_bench_command(CLI::App& app, BenchOptions& options) {
  CLI::App* command = app.add_subcommand("bench", "one part of `granary bench pbm` (docs/bench.md), as JSON");
  command->add_option("PART", options.part, "rhs, work-precision, temporal, published, row or twins")
      ->required()
      ->check(CLI::IsMember({"rhs", "work-precision", "temporal", "published", "row", "twins"}));
  CLI::Option* quick = command->add_flag("--quick", options.quick, "a few seconds a part");
  command->add_flag("--full", options.full, "also what the reference needs many minutes for")->excludes(quick);
  command->add_option("--threads", options.threads, "row: threads of each rank")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_option("--seconds", options.seconds, "row: wall time of each of its two measurements")
      ->check(CLI::Range(0.01, 600.0))
      ->capture_default_str();
  command->add_option("--seeds", options.seeds, "twins: so many of each problem")->check(CLI::Range(1, 1000));
  command->add_option("--parameters", options.parameters, "twins: only problems of 2, 4 or 6")
      ->check(CLI::IsMember({2, 4, 6}));
  command->add_flag("--product", options.product, "twins: only the one in which only a product can be found");
  command->add_flag("--write", options.write, "twins: print the first problem, with what was hidden");
  command->add_option("--method", options.methods, "twins: only this one (may be repeated)");
  return command;
}

int run_bench_command(const BenchOptions& options) {
  if (options.part == "row") return run_row(options);
  if (options.part == "twins") {
    std::printf("%s\n", json::dump(run_twins(options), 1).c_str());
    return 0;
  }
  const auto effort = options.quick ? bench::Effort::quick : options.full ? bench::Effort::full : bench::Effort::usual;
  std::printf("%s\n", json::dump(run_part(options.part, effort), 1).c_str());
  return 0;
}

}  // namespace granary::pbm
