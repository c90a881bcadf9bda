#include <fmt/format.h>

#include <chrono>
#include <cstdio>

#include "common/json/io.hpp"
#include "controller/bench/pbm_parts.hpp"
#include "controller/bench/pbm_plot.hpp"
#include "controller/bench/pbm_table.hpp"
#include "controller/commands/commands.hpp"

namespace granary::commands {

Result<Exit> bench_pbm(const BenchOptions& options) {
  const auto began = std::chrono::steady_clock::now();
  const auto seconds = [began] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  };
  const auto effort = options.quick ? bench::Effort::quick : options.full ? bench::Effort::full : bench::Effort::usual;
  GRANARY_TRY(json::Value document, bench::run_pbm_bench(effort, [&](const std::string& what) {
                fmt::print(stderr, "bench pbm: {:6.1f} s  {}\n", seconds(), what);
              }));
  document.set("wall_s", seconds());
  fmt::print(stderr, "bench pbm: {:6.1f} s  done\n", seconds());
  fmt::print("{}\n", options.json ? json::dump(document, 1) : bench::pbm_table(document));
  if (!options.plot.empty()) GRANARY_CHECK(bench::draw_work_precision(document, options.plot));
  return Exit::ok;
}

}  // namespace granary::commands
