// LIGGGHTS ends the program with exit code 1 for whatever it dislikes, and says why on stdout. Here its message also
// goes to stderr, and the exit code tells bad input (2) from a run that diverged (20) or failed (3).
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace granary::dem {

/// From here on; before LIGGGHTS exists its errors are about its arguments.
void watch_liggghts_errors();
/// Reads along what it prints.
void watch_liggghts_errors(LAMMPS_NS::LAMMPS& lammps);
/// It is about to be taken down in good order.
void forget_liggghts();

}  // namespace granary::dem
