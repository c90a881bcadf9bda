// The commands of `granary`: each takes what the command line says and returns the exit code. Results go to stdout,
// progress and errors to stderr.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace granary::commands {

struct RunOptions {
  std::filesystem::path workflow;
  std::filesystem::path dir;  ///< run directory; empty: runs/NAME, or the first free runs/NAME-2, ...
  int cores = 0;              ///< 0: the workflow's, or all of the machine
  int nodes = 0;              ///< dry run only; 0: the workflow's
  int virtual_nodes = 0;      ///< > 0: so many agents on this machine
  bool dry_run = false;
  bool json = false;
  bool quiet = false;
  std::vector<std::string> overrides;  ///< "/pointer=value"
};

struct BenchOptions {
  bool quick = false, full = false;  ///< about 20 s; all that the reference needs many minutes for
  bool json = false;
  std::filesystem::path plot;  ///< the work-precision plot, an SVG file; empty: none
};

struct PilotBenchOptions {
  bool quick = false;  ///< some 15 s
  bool json = false;
  int cores = 0;              ///< 0: all
  std::string simulate;       ///< only this simulation: "nodes=10000,cores=64,tasks=1000000"
  bool slurm = false;         ///< only agents beside srun, inside of a job
  std::filesystem::path dir;  ///< where to work; empty: the system's folder for temporary files
};

struct DemBenchOptions {
  std::string effort = "usual";  ///< quick, usual, full
  bool json = false;
  std::vector<std::string> only;  ///< parts: speed, overheads, comparison, choices; empty: all
  std::filesystem::path plot;     ///< folder for dem_speed.svg and dem_choices.svg; empty: none
};

struct EstimationBenchOptions {
  std::string effort = "usual";  ///< quick, usual, full
  bool json = false;
  std::filesystem::path workflow;  ///< a coupled campaign with an estimation, to run on and off; empty: none
  std::filesystem::path plot;      ///< of the twin experiments, an SVG file; empty: none
};

Result<Exit> run(const RunOptions& options);
/// The workflow's section "estimation" alone, on all cores.
Result<Exit> estimate(const RunOptions& options);
Result<Exit> dry_run(const RunOptions& options);
Result<Exit> resume(const std::filesystem::path& dir, bool json, bool quiet, int virtual_nodes);
/// `options.workflow`: a workflow, or the folder of a campaign to go on with.
Result<Exit> submit(const RunOptions& options);
/// The run directory, absolute: the one given, else runs/NAME, or the first of runs/NAME-2, ... that is free.
std::filesystem::path run_folder(const std::filesystem::path& given, const std::string& name);

Result<Exit> validate(const std::vector<std::filesystem::path>& workflows, const std::vector<std::string>& overrides);
Result<Exit> status(const std::filesystem::path& dir, bool json);
/// Shows a campaign live until it has ended: the exit code is its own; ok if the user leaves before.
Result<Exit> watch(const std::filesystem::path& dir);
/// The same as a web page, until Ctrl-C. `port` 0: any.
Result<Exit> serve(const std::filesystem::path& dir, const std::string& address, int port);
Result<Exit> stop(const std::filesystem::path& dir);
Result<Exit> explain(const std::filesystem::path& dir, const std::string& task);
/// Queues the tasks of a file with the pilot that lives on `dir`; prints their names.
Result<Exit> submit_tasks(const std::filesystem::path& dir, const std::filesystem::path& file);
/// report.html; also its figures as FIGURES/PREFIXname.svg, if a folder for them is given.
Result<Exit> report(const std::filesystem::path& dir, const std::filesystem::path& figures, const std::string& prefix);
Result<Exit> bench_pilot(const PilotBenchOptions& options);
Result<Exit> bench_pbm(const BenchOptions& options);
Result<Exit> bench_dem(const DemBenchOptions& options);
Result<Exit> bench_estimation(const EstimationBenchOptions& options);

struct CompareCommand {
  std::vector<std::filesystem::path> dirs;               ///< run directories; the first is the reference
  double at = std::numeric_limits<double>::quiet_NaN();  ///< process time [s]; NaN: where the first of them ends
  std::filesystem::path plot;                            ///< SVG file to draw; empty: none
  bool json = false;
};
/// Campaigns side by side: settings, granules, wall time.
Result<Exit> compare(const CompareCommand& command);

struct KernelCommand {
  std::filesystem::path dir;          ///< of a sweep of a DEM with agglomerates, over or not
  std::vector<std::string> held_out;  ///< cases, or values of settings, that are only compared
  double from = 0.0;                  ///< [s]
  bool by_impacts = false;            ///< rates go by what hits, as measured, not by the settings
  bool json = false;
};
/// DIR/kernel: a breakage kernel made of the sweep's fragments, and how well a balance with it does.
Result<Exit> kernel(const KernelCommand& command);

}  // namespace granary::commands
