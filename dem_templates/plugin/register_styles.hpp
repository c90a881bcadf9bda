// Adds our fixes to LIGGGHTS' table of fix styles.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace granary::dem {

/// granary/tally, granary/outlet, granary/guard and granary/resize: docs/dem_styles.md.
void register_styles(LAMMPS_NS::LAMMPS& lammps);

}  // namespace granary::dem
