// granary: the command line. What each command does is in commands/.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>

#include "common/version.hpp"
#include "controller/commands/commands.hpp"

namespace {

using granary::Exit;
using granary::Result;
namespace commands = granary::commands;
namespace fs = std::filesystem;

constexpr const char* kExamples = R"(
Examples:
  granary validate workflows/quick.json
  granary run workflows/quick.json                      run here, in runs/quick
  granary run workflows/cm5.json --dry-run --nodes 4 --cores 64
  granary run workflows/quick.json --set /pbm/bins=[32,32] --set '/machine/impeller_speed="1500 rpm"'
  granary estimate workflows/estimate_twin.json         parameters from data, without a DEM
  granary watch runs/quick       granary serve runs/quick
  granary status runs/quick      granary stop runs/quick      granary resume runs/quick

Exit codes: 0 done, 2 bad input, 3 a task failed for good, 4 stopped and resumable, 70 our own fault.)";

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Granary: one JSON workflow, one block of cores, DEM and population balances coupled both ways.",
               "granary"};
  app.footer(kExamples);
  app.require_subcommand(1);
  app.set_version_flag("--version", fmt::format("granary {} ({})", granary::version(), granary::revision()));
  std::function<Result<Exit>()> chosen;

  commands::RunOptions options;
  auto* run = app.add_subcommand("run", "Run a workflow to its end");
  run->add_option("workflow", options.workflow, "The workflow, a JSON file")->required();
  run->add_option("--dir", options.dir, "Run directory (default: runs/NAME)");
  run->add_option("--cores", options.cores, "Cores (of a node) to use (default: the workflow's, else all)")
      ->check(CLI::PositiveNumber);
  run->add_option("--nodes", options.nodes, "Nodes of the machine to assume (dry run only)")
      ->check(CLI::PositiveNumber);
  run->add_option("--virtual-nodes", options.virtual_nodes,
                  "Agents on this machine, as if it were so many nodes (to try)")
      ->check(CLI::Range(1, 64));
  run->add_option("--set", options.overrides, "Override a setting: /pointer=value (may be repeated)");
  run->add_flag("--dry-run", options.dry_run, "The same controller and scheduler on a virtual clock: starts nothing");
  run->add_flag("--json", options.json, "Print one JSON document on stdout and nothing else");
  run->add_flag("-q,--quiet", options.quiet, "No progress");
  run->callback([&] { chosen = [&] { return commands::run(options); }; });

  auto* estimate = app.add_subcommand("estimate", "Fit parameters of the population balance to data, without a DEM");
  estimate->footer(
      "\nExamples:\n  granary estimate workflows/estimate_twin.json\n"
      "  granary estimate workflows/estimate_twin.json --set '/estimation/method=\"cma-es\"' --dir runs/other\n"
      "  granary resume runs/estimate_twin     go on after a stop or a kill (docs/estimation.md)");
  estimate->add_option("workflow", options.workflow, "The workflow, with a section \"estimation\"")->required();
  estimate->add_option("--dir", options.dir, "Run directory (default: runs/NAME)");
  estimate->add_option("--cores", options.cores, "Cores (of a node) to use (default: the workflow's, else all)")
      ->check(CLI::PositiveNumber);
  estimate->add_option("--virtual-nodes", options.virtual_nodes, "Agents on this machine, as in `run`")
      ->check(CLI::Range(1, 64));
  estimate->add_option("--set", options.overrides, "Override a setting: /pointer=value (may be repeated)");
  estimate->add_flag("--json", options.json, "Print one JSON document on stdout and nothing else");
  estimate->add_flag("-q,--quiet", options.quiet, "No progress");
  estimate->callback([&] { chosen = [&] { return commands::estimate(options); }; });

  auto* submit = app.add_subcommand("submit", "Run a workflow as one job of Slurm, or go on with a campaign that way");
  submit->add_option("workflow", options.workflow, "The workflow, or the run directory of a campaign")->required();
  submit->add_option("--dir", options.dir, "Run directory (default: runs/NAME); all nodes must see it");
  submit->add_option("--set", options.overrides, "Override a setting: /pointer=value (may be repeated)");
  submit->add_flag("--dry-run", options.dry_run, "Print the job's script and submit nothing");
  submit->callback([&] { chosen = [&] { return commands::submit(options); }; });

  std::vector<fs::path> workflows;
  auto* validate = app.add_subcommand("validate", "Say everything that is wrong with workflows");
  validate->add_option("workflows", workflows, "Workflows")->required();
  validate->add_option("--set", options.overrides, "Override a setting: /pointer=value (may be repeated)");
  validate->callback([&] { chosen = [&] { return commands::validate(workflows, options.overrides); }; });

  fs::path dir;
  std::string task;
  const auto on_folder = [&](const char* name, const char* what, std::function<Result<Exit>()> command) {
    auto* sub = app.add_subcommand(name, what);
    sub->add_option("dir", dir, "Run directory")->required();
    sub->callback([&chosen, command = std::move(command)] { chosen = command; });
    return sub;
  };
  on_folder("status", "What runs, what waits, what has ended", [&] {
    return commands::status(dir, options.json);
  })->add_flag("--json", options.json, "Print one JSON document");
  on_folder("watch", "See it live: on a terminal a picture, else lines; ends with the campaign, with its exit code",
            [&] { return commands::watch(dir); });
  std::string address = "127.0.0.1";
  int port = 0;
  auto* serve = on_folder("serve", "The same as a web page of this machine; prints its address",
                          [&] { return commands::serve(dir, address, port); });
  serve->add_option("--port", port, "Port (default: one that is free)")->check(CLI::Range(0, 65535));
  serve->add_option("--address", address,
                    "Listen on this address; without TLS, so others than loopback let it be read");
  on_folder("stop", "End a running campaign gracefully, to be resumed", [&] { return commands::stop(dir); });
  auto* resume = on_folder("resume", "Go on after a stop, a kill or a crash",
                           [&] { return commands::resume(dir, options.json, options.quiet, options.virtual_nodes); });
  resume->add_option("--virtual-nodes", options.virtual_nodes, "Agents on this machine, as in `run`")
      ->check(CLI::Range(1, 64));
  resume->add_flag("--json", options.json, "Print one JSON document on stdout and nothing else");
  resume->add_flag("-q,--quiet", options.quiet, "No progress");
  on_folder("explain", "Why a task waits, what it did, what it cost", [&] { return commands::explain(dir, task); })
      ->add_option("task", task, "Its name, such as 0001-dem")
      ->required();
  fs::path figures;
  std::string prefix;
  auto* report =
      on_folder("report", "results.h5 -> report.html; of a sweep from its cases' folders, also before its end",
                [&] { return commands::report(dir, figures, prefix); });
  report->add_option("--figures", figures, "Also draw its figures into this folder, as SVG");
  report->add_option("--prefix", prefix, "Of the names of those files");

  commands::CompareCommand compare_command;
  auto* compare = app.add_subcommand("compare", "Campaigns side by side: what a setting changes, and what it costs");
  compare->footer(
      "\nExamples:\n  granary compare runs/cm5 runs/cm5-finer\n"
      "  granary compare runs/cm5 runs/cm5-* --at 100 --plot d50.svg     at 100 s of the process, with a plot");
  compare->add_option("dirs", compare_command.dirs, "Run directories; the first is the reference")
      ->required()
      ->expected(2, 1000);
  compare->add_option("--at", compare_command.at, "Process time [s] (default: where the first of them ends)")
      ->check(CLI::NonNegativeNumber);
  compare->add_option("--plot", compare_command.plot, "Draw d50 of what flows out into this SVG file");
  compare->add_flag("--json", compare_command.json, "Print one JSON document on stdout and nothing else");
  compare->callback([&] { chosen = [&] { return commands::compare(compare_command); }; });

  commands::KernelCommand kernel_command;
  auto* kernel = app.add_subcommand("kernel", "A breakage kernel from a sweep of resolved breakage (docs/breakage.md)");
  kernel->add_option("dir", kernel_command.dir, "Run directory of the sweep")->required();
  kernel->add_option(
      "--held-out", kernel_command.held_out,
      "A case (0007) or a value of a setting (\"200 rpm\") that is not fitted, only compared (may be repeated)");
  kernel->add_option("--from", kernel_command.from, "Leave out what breaks before this time [s]");
  kernel->add_flag("--by-impacts", kernel_command.by_impacts,
                   "Rates go by the power that impacts bring, as measured in each case, not by its settings");
  kernel->add_flag("--json", kernel_command.json, "Print one JSON document on stdout and nothing else");
  kernel->callback([&] { chosen = [&] { return commands::kernel(kernel_command); }; });

  fs::path task_file;
  auto* task_command = app.add_subcommand("task", "Tasks of a running campaign");
  task_command->require_subcommand(1);
  auto* submit_task =
      task_command->add_subcommand("submit", "Queue the tasks of a JSON file (one, a list, or a workflow)");
  submit_task->add_option("dir", dir, "Run directory")->required();
  submit_task->add_option("file", task_file, "{\"name\": ..., \"command\": [...]}: docs/pilot.md")->required();
  submit_task->callback([&] { chosen = [&] { return commands::submit_tasks(dir, task_file); }; });

  commands::BenchOptions bench_options;
  auto* bench = app.add_subcommand("bench", "Measure what our programs cost, on this machine");
  bench->require_subcommand(1);
  auto* bench_pbm = bench->add_subcommand("pbm", "granary-pbm beside a plain reference (docs/bench.md)");
  auto* quick = bench_pbm->add_flag("--quick", bench_options.quick, "About 20 s instead of some 3 minutes");
  bench_pbm->add_flag("--full", bench_options.full, "Also what the reference needs many minutes for")->excludes(quick);
  bench_pbm->add_flag("--json", bench_options.json, "Print one JSON document on stdout and nothing else");
  bench_pbm->add_option("--plot", bench_options.plot, "Draw error against CPU time into this SVG file");
  bench_pbm->callback([&] { chosen = [&] { return commands::bench_pbm(bench_options); }; });

  commands::PilotBenchOptions pilot_options;
  auto* bench_pilot =
      bench->add_subcommand("pilot", "The pilot on this machine, and simulated at scale (docs/pilot.md)");
  bench_pilot->footer(
      "\nExamples:\n  granary bench pilot                all of it: some 2 minutes\n"
      "  granary bench pilot --quick --json\n"
      "  granary bench pilot --simulate nodes=10000,cores=64,tasks=1000000   only the simulation, no process is "
      "started");
  bench_pilot->add_flag("--quick", pilot_options.quick, "Some 15 s: fewer tasks, shorter runs");
  bench_pilot->add_flag("--json", pilot_options.json, "Print one JSON document on stdout and nothing else");
  bench_pilot->add_option("--cores", pilot_options.cores, "Cores to use (default: all)")->check(CLI::PositiveNumber);
  bench_pilot->add_option("--simulate", pilot_options.simulate, "Only simulate: nodes=N,cores=C,tasks=T");
  bench_pilot->add_flag("--slurm", pilot_options.slurm,
                        "Only tasks through agents beside srun, inside of a job of Slurm");
  bench_pilot->add_option("--dir", pilot_options.dir, "Folder to work in (default: that for temporary files)");
  bench_pilot->callback([&] { chosen = [&] { return commands::bench_pilot(pilot_options); }; });

  commands::DemBenchOptions dem_options;
  auto* bench_dem = bench->add_subcommand("dem", "granary-dem beside stock LIGGGHTS (docs/dem_bench.md)");
  bench_dem->footer(
      "\nExamples:\n  granary bench dem                              all of it: some 7 minutes\n"
      "  granary bench dem --effort quick --only speed  ratios, with few repeats\n"
      "  granary bench dem --json --plot docs/images    for the docs: figures and both plots");
  bench_dem->add_option("--effort", dem_options.effort, "quick (some 3 minutes), usual or full (an hour)")
      ->check(CLI::IsMember({"quick", "usual", "full"}));
  bench_dem->add_option("--only", dem_options.only, "Only this part (may be repeated)")
      ->check(CLI::IsMember({"speed", "overheads", "comparison", "choices"}));
  bench_dem->add_flag("--json", dem_options.json, "Print one JSON document on stdout and nothing else");
  bench_dem->add_option("--plot", dem_options.plot, "Draw dem_speed.svg and dem_choices.svg into this folder");
  bench_dem->callback([&] { chosen = [&] { return commands::bench_dem(dem_options); }; });

  commands::EstimationBenchOptions estimation_options;
  auto* bench_estimation = bench->add_subcommand(
      "estimation",
      "How often estimation finds what was hidden, and what it does with idle cores (docs/estimation.md)");
  bench_estimation
      ->add_option("--effort", estimation_options.effort, "quick (a minute), usual or full (an hour of a core)")
      ->check(CLI::IsMember({"quick", "usual", "full"}));
  bench_estimation->add_option("--workflow", estimation_options.workflow,
                               "Also run this coupled campaign with its estimation and without");
  bench_estimation->add_option("--plot", estimation_options.plot, "Draw the twin experiments into this SVG file");
  bench_estimation->add_flag("--json", estimation_options.json, "Print one JSON document on stdout and nothing else");
  bench_estimation->callback([&] { chosen = [&] { return commands::bench_estimation(estimation_options); }; });

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(Exit::bad_input);
  }
  const auto result = chosen();
  if (result) return static_cast<int>(*result);
  fmt::print(stderr, "{}\n", result.error().message);
  return static_cast<int>(result.error().exit);
}
