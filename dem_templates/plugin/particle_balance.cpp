#include "dem_templates/plugin/particle_balance.hpp"

#include <mpi.h>

#include <atom.h>
#include <fix_insert.h>
#include <lammps.h>
#include <modify.h>

#include "dem_templates/plugin/fix_outlet.hpp"

namespace granary::dem {

ParticleBalance count_particles(LAMMPS_NS::LAMMPS& lammps) {
  ParticleBalance balance;
  long mine[2] = {lammps.atom->nlocal, 0};
  for (int i = 0; i < lammps.modify->nfix; ++i) {
    LAMMPS_NS::Fix* fix = lammps.modify->fix[i];
    // element 0 of an insert fix's vector: particles inserted so far, on all ranks
    if (auto* insert = dynamic_cast<LAMMPS_NS::FixInsert*>(fix))
      balance.inserted += static_cast<long>(insert->compute_vector(0));
    if (auto* outlet = dynamic_cast<FixOutlet*>(fix)) mine[1] += outlet->left_here();
  }
  long sum[2];
  MPI_Allreduce(mine, sum, 2, MPI_LONG, MPI_SUM, lammps.world);
  balance.present = sum[0];
  balance.left = sum[1];
  return balance;
}

}  // namespace granary::dem
