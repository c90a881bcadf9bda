#include "dem_templates/plugin/liggghts_errors.hpp"

#include <mpi.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include <lammps.h>
#include <update.h>

#include "common/result.hpp"
#include "dem_templates/plugin/ending.hpp"

namespace granary::dem {
namespace {

constexpr int kLiggghtsGaveUp = 1;  // Error::all and Error::one know no other code

// The errors of LIGGGHTS end the program from within: there is no caller to hand this to.
struct OutputWatch {
  LAMMPS_NS::LAMMPS* lammps = nullptr;
  FILE* screen = nullptr;  // where its output goes on to; may be none
  std::string line;        // the line being printed
  std::string error;       // the first line that began with ERROR
} watch;

ssize_t read_along(void*, const char* text, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    if (text[i] != '\n') {
      watch.line += text[i];
      continue;
    }
    if (watch.error.empty() && watch.line.rfind("ERROR", 0) == 0) watch.error = watch.line;
    watch.line.clear();
  }
  if (watch.screen) {
    std::fwrite(text, 1, size, watch.screen);
    std::fflush(watch.screen);
  }
  return static_cast<ssize_t>(size);
}

// What numbers that ran away make LIGGGHTS say.
bool speaks_of_divergence(std::string_view message) {
  for (std::string_view words : {"unstable", "Lost atoms", "on-numeric", "out of range", "atoms too far", "NaN"})
    if (message.find(words) != std::string_view::npos) return true;
  return false;
}

bool in_a_run() {
  return watch.lammps && watch.lammps->update && watch.lammps->update->whichflag != 0 &&
         watch.lammps->update->ntimestep > watch.lammps->update->firststep;
}

int exit_code() {
  if (!in_a_run()) return static_cast<int>(Exit::bad_input);
  return speaks_of_divergence(watch.error) ? kDivergedExit : static_cast<int>(Exit::task_failed);
}

int explain() {
  std::fflush(nullptr);
  const std::string& said = watch.error.empty() ? watch.line : watch.error;
  if (!said.empty())
    std::fprintf(stderr, "granary-dem: LIGGGHTS: %s\n", said.c_str());
  else if (!watch.lammps)
    std::fputs("granary-dem: LIGGGHTS could not start with these arguments. See granary-dem --help\n", stderr);
  std::fflush(nullptr);
  return exit_code();
}

void at_exit(int code, void*) {
  if (code == kLiggghtsGaveUp) _exit(explain());
}

}  // namespace

void watch_liggghts_errors() { on_exit(at_exit, nullptr); }

void watch_liggghts_errors(LAMMPS_NS::LAMMPS& lammps) {
  watch.lammps = &lammps;
  watch.screen = lammps.screen;
  lammps.screen = fopencookie(nullptr, "w", {nullptr, read_along, nullptr, nullptr});
  setvbuf(lammps.screen, nullptr, _IOLBF, 0);
}

void forget_liggghts() {
  std::fflush(nullptr);
  watch.lammps = nullptr;
}

}  // namespace granary::dem

// MPI's own hook for tools: LIGGGHTS' call lands here, since the program's symbols come before the library's.
extern "C" int MPI_Abort(MPI_Comm comm, int code) {
  return PMPI_Abort(comm, code == granary::dem::kLiggghtsGaveUp ? granary::dem::explain() : code);
}
