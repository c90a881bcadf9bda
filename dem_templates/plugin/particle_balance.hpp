// How many particles there are, and how many came and went by doors we know.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace granary::dem {

/// Counts since the program started; the same on all ranks.
struct ParticleBalance {
  long present = 0;
  long inserted = 0;  ///< by LIGGGHTS' insert fixes
  long left = 0;      ///< by granary/outlet

  /// Particles that went missing on the way from `before` to here.
  long lost_since(const ParticleBalance& before) const {
    return before.present + (inserted - before.inserted) - (left - before.left) - present;
  }
};

/// All ranks call it.
ParticleBalance count_particles(LAMMPS_NS::LAMMPS& lammps);

}  // namespace granary::dem
