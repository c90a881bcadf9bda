#include <fmt/format.h>

#include <chrono>
#include <cstdio>

#include "common/json/io.hpp"
#include "controller/bench/estimation_bench.hpp"
#include "controller/bench/estimation_plot.hpp"
#include "controller/bench/scratch_folder.hpp"
#include "controller/commands/commands.hpp"

namespace granary::commands {

Result<Exit> bench_estimation(const EstimationBenchOptions& options) {
  const auto began = std::chrono::steady_clock::now();
  const auto seconds = [began] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  };
  const auto scratch = bench::ScratchFolder::make(std::filesystem::temp_directory_path());
  if (!scratch) return Error{"no folder can be made in the folder for temporary files. Set TMPDIR to one with room."};
  bench::EstimationBench bench;
  bench.effort = options.effort == "quick"  ? bench::Effort::quick
                 : options.effort == "full" ? bench::Effort::full
                                            : bench::Effort::usual;
  bench.dir = scratch->path();
  bench.workflow = options.workflow;
  GRANARY_TRY(json::Value document, bench::run_estimation_bench(bench, [&](const std::string& what) {
                fmt::print(stderr, "bench estimation: {:6.1f} s  {}\n", seconds(), what);
              }));
  document.set("wall_s", seconds());
  if (!options.plot.empty()) GRANARY_CHECK(bench::draw_twins(document, options.plot));
  fmt::print(stderr, "bench estimation: {:6.1f} s  done\n", seconds());
  fmt::print("{}\n", options.json ? json::dump(document, 1) : bench::estimation_table(document));
  return Exit::ok;
}

}  // namespace granary::commands
