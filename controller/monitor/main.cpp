// granary-monitor: watches one running burst; its exit code is its verdict.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "common/json/io.hpp"
#include "common/version.hpp"
#include "controller/monitor/follow.hpp"

namespace {

using namespace granary;           // NOLINT: a program, not a header
using namespace granary::monitor;  // NOLINT

constexpr const char* kFooter =
    R"(Exit codes: 10 drifted, 11 steady, 12 converged, 20 diverged, 0 the program ended by itself (or SIGTERM), 2 bad input.
The verdict is one JSON line on stdout (docs/exchange_formats.md#monitors).

Examples:
  granary-monitor dem bursts/0001-dem
  granary-monitor dem bursts/0001-dem --threshold 0.15 --grace 0.05 --steady-window 0.5 --converged-tolerance 0.03
  granary-monitor pbm bursts/0001-pbm --pid 4711
  granary-monitor pbm bursts/0001-pbm --finished     judge a burst that is over)";

/// What both subcommands may be given; unset numbers keep the program's own default.
struct Arguments {
  std::string folder;
  Options options;
  int pid = 0;
  bool finished = false, no_drift = false;
  double look_every = 1.0;
};

void describe(CLI::App& command, Arguments& given, Program program) {
  given.options = default_options(program);
  command
      .add_option("folder", given.folder,
                  "the burst's folder, where " + std::string(watched_file(program)) + " is or will be")
      ->required()
      ->type_name("DIR");
  command
      .add_option("--threshold", given.options.threshold, "relative change that is a drift, and the bound of steady")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      .add_option("--grace", given.options.grace,
                  "seconds of the program's clock at the burst's start that are not looked at")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command
      .add_option("--steady-window", given.options.steady_window,
                  "seconds over which nothing may move; 0: never say steady")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command
      .add_option("--converged-tolerance", given.options.converged_tolerance,
                  "relative standard error of the watched means; 0: never say converged")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command.add_option("--significance", given.options.significance, "standard errors a change must exceed to be one")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command.add_flag("--no-drift", given.no_drift, "never say drifted");
  auto* pid = command.add_option("--pid", given.pid, "of the watched program, on this machine: its end is the end")
                  ->check(CLI::PositiveNumber);
  command.add_flag("--finished", given.finished, "the program has ended: judge what is there")->excludes(pid);
  command.add_option("--look-every", given.look_every, "seconds between looks where the file system sends no notices")
      ->check(CLI::Range(0.01, 3600.0))
      ->capture_default_str();
}

int run(const Arguments& given, Program program) {
  FollowSettings settings{program, given.folder, given.options, std::nullopt, given.finished, given.look_every};
  settings.options.watch_drift = !given.no_drift;
  if (given.pid > 0) settings.pid = given.pid;
  const auto verdict = follow(settings);
  if (!verdict) {
    std::fprintf(stderr, "%s\n", verdict.error().message.c_str());
    return static_cast<int>(verdict.error().exit);
  }
  std::printf("%s\n", json::dump(to_json(*verdict)).c_str());
  return exit_code(verdict->outcome);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Watches one running burst and ends with a verdict.", "granary-monitor"};
  app.set_version_flag("--version", std::string(version()));
  app.footer(kFooter);
  app.require_subcommand(1);
  Arguments of_dem, of_pbm;
  CLI::App* dem = app.add_subcommand("dem", "watch a DEM burst: mean speeds by class, collisions, impacts");
  CLI::App* pbm = app.add_subcommand("pbm", "watch a PBM burst: d50 and particle number by compartment");
  describe(*dem, of_dem, Program::dem);
  describe(*pbm, of_pbm, Program::pbm);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& fault) {
    return app.exit(fault) == 0 ? 0 : static_cast<int>(Exit::bad_input);
  }
  return dem->parsed() ? run(of_dem, Program::dem) : run(of_pbm, Program::pbm);
}
