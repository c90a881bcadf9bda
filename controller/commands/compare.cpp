#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "controller/commands/commands.hpp"
#include "controller/report/comparison.hpp"
#include "controller/report/gnuplot.hpp"

namespace granary::commands {
namespace fs = std::filesystem;

Result<Exit> compare(const CompareCommand& command) {
  std::vector<report::NamedResults> runs;
  std::vector<std::string> problems;
  for (const fs::path& dir : command.dirs) {
    auto results = read_results(dir / "results.h5");
    if (!results) {
      problems.push_back(results.error().message);
      continue;
    }
    runs.push_back({fs::absolute(dir / ".").lexically_normal().parent_path().filename().string(), std::move(*results)});
  }
  if (!problems.empty()) return Error{fmt::format("{}", fmt::join(problems, "\n"))};

  GRANARY_TRY(const report::Comparison comparison, report::compare(runs, command.at));
  if (!command.plot.empty()) {
    report::GnuplotPlotter gnuplot;
    GRANARY_TRY(const std::vector<std::string> drawings, gnuplot.draw({report::outlet_plot(runs)}));
    GRANARY_CHECK(write_text_atomically(command.plot, report::as_file(drawings.front())));
  }
  fmt::print("{}\n", command.json ? json::dump(report::to_json(comparison), 2) : report::table(comparison));
  return Exit::ok;
}

}  // namespace granary::commands
