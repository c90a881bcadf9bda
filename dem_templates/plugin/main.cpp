// granary-dem: LIGGGHTS with our styles, and with exit codes that tell what happened (docs/exchange_formats.md).
#include <mpi.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include <input.h>
#include <lammps.h>

#include "common/launched_by_mpi.hpp"
#include "common/version.hpp"
#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_guard.hpp"
#include "dem_templates/plugin/liggghts_errors.hpp"
#include "dem_templates/plugin/register_styles.hpp"
#include "dem_templates/plugin/state_file.hpp"
#include "dem_templates/plugin/stop_signal.hpp"

namespace {

constexpr const char* kHelp =
    "Usage: granary-dem -in FILE [-log FILE] [-screen FILE|none] [-echo none|screen|log|both] [-var NAME VALUE...]\n"
    "\n"
    "LIGGGHTS 3.8.0 with the fixes granary/wall, granary/bond, granary/agglomerates, granary/tally, granary/outlet,\n"
    "granary/guard, granary/resize, granary/skin, granary/lists and granary/balance (docs/dem_styles.md).\n"
    "Over several ranks: mpirun -n 2 granary-dem -in FILE\n"
    "\n"
    "SIGTERM, SIGINT, SIGUSR1 (the one mpirun passes on): finish the step, write the restart file, end.\n"
    "Ends with 0 done or stopped, 2 bad input, 3 LIGGGHTS failed on the way, 20 diverged.\n";

// Whatever the script did: the state it ends with is on disk, or the program fails.
void write_last_state(LAMMPS_NS::LAMMPS& lammps) {
  const granary::dem::FixGuard* guard = granary::dem::find_guard(lammps);
  if (!guard || !guard->started()) return;
  granary::dem::end_if_failed(lammps.world, granary::dem::write_state(lammps, guard->restart_file()));
  int rank = 0;
  MPI_Comm_rank(lammps.world, &rank);
  if (rank == 0 && guard->stopping())
    std::fprintf(stderr, "granary-dem: stopped as asked; the state is in %s\n", guard->restart_file().c_str());
}

// One rank alone needs no network, no daemon and no list of devices. Open MPI looks for all of them before a lone
// program's first step, for half a second. Who sets these in the environment knows better. In a step of Slurm it takes
// the program for one of many: only who started it knows that it is not (GRANARY_LONE_RANK).
void start_mpi(int& argc, char**& argv) {
  const bool is_told = std::getenv("GRANARY_LONE_RANK") != nullptr;
  if (!granary::launched_by_mpi() && (is_told || std::getenv("SLURM_STEP_ID") == nullptr)) {
    unsetenv("SLURM_STEP_ID");
    setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
    setenv("OMPI_MCA_pml", "ob1", 0);
    setenv("OMPI_MCA_btl", "self", 0);
    setenv("HWLOC_COMPONENTS", "-pci,-linuxio", 0);
  }
  MPI_Init(&argc, &argv);
}

bool given(int argc, char** argv, const char* word) { return argc > 1 && std::strcmp(argv[1], word) == 0; }

const char* input_script(int argc, char** argv) {
  for (int i = 1; i + 1 < argc; ++i)
    if (std::strcmp(argv[i], "-in") == 0 || std::strcmp(argv[i], "-i") == 0) return argv[i + 1];
  return nullptr;
}

}  // namespace

int main(int argc, char** argv) {
  if (given(argc, argv, "--help") || given(argc, argv, "-h")) return std::fputs(kHelp, stdout), 0;
  if (given(argc, argv, "--version")) {
    std::printf("granary-dem %s (%s), LIGGGHTS 3.8.0\n", std::string(granary::version()).c_str(),
                std::string(granary::revision()).c_str());
    return 0;
  }
  if (argc < 2) return std::fputs(kHelp, stderr), static_cast<int>(granary::Exit::bad_input);

  if (const char* script = input_script(argc, argv); script && access(script, R_OK) != 0) {
    std::fprintf(stderr, "granary-dem: the input script %s cannot be read: %s\n", script, std::strerror(errno));
    return static_cast<int>(granary::Exit::bad_input);
  }

  granary::dem::install_stop_signals();
  start_mpi(argc, argv);
  granary::dem::watch_liggghts_errors();
  {
    LAMMPS_NS::LAMMPS lammps(argc, argv, MPI_COMM_WORLD);
    granary::dem::watch_liggghts_errors(lammps);
    granary::dem::register_styles(lammps);
    lammps.input->file();
    write_last_state(lammps);
    granary::dem::forget_liggghts();
  }
  MPI_Finalize();
  return 0;
}
