// The state a burst ends with, on disk: whole, or not at all and said so.
#pragma once

#include <string>

#include "common/result.hpp"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace granary::dem {

/// LIGGGHTS' write_restart does not notice a full disk. So let it write into memory, then write that to FILE.part with
/// every byte checked, and rename. All ranks call it; rank 0 has the status, the others a good one.
Status write_state(LAMMPS_NS::LAMMPS& lammps, const std::string& file);

}  // namespace granary::dem
