#include <fmt/format.h>

#include <chrono>
#include <cstdio>

#include "common/json/io.hpp"
#include "controller/bench/dem_bench.hpp"
#include "controller/bench/dem_plot.hpp"
#include "controller/bench/dem_table.hpp"
#include "controller/commands/commands.hpp"

namespace granary::commands {

Result<Exit> bench_dem(const DemBenchOptions& options) {
  const auto began = std::chrono::steady_clock::now();
  const auto seconds = [began] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  };
  const auto effort = options.effort == "quick"  ? bench::Effort::quick
                      : options.effort == "full" ? bench::Effort::full
                                                 : bench::Effort::usual;
  GRANARY_TRY(json::Value document, bench::run_dem_bench(effort, options.only, [&](const std::string& what) {
                fmt::print(stderr, "bench dem: {:6.1f} s  {}\n", seconds(), what);
              }));
  document.set("wall_s", seconds());
  fmt::print(stderr, "bench dem: {:6.1f} s  done\n", seconds());
  fmt::print("{}\n", options.json ? json::dump(document, 1) : bench::dem_table(document));
  if (!options.plot.empty()) GRANARY_CHECK(bench::draw_dem(document, options.plot));
  return Exit::ok;
}

}  // namespace granary::commands
