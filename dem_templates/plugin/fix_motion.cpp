#include "dem_templates/plugin/fix_motion.hpp"

#include <mpi.h>

#include <atom.h>
#include <domain.h>
#include <group.h>

#include "dem_templates/plugin/motion/sphere_motion.hpp"

namespace granary::dem {
namespace {

SphereArrays arrays_of(const LAMMPS_NS::Atom& atom) {
  return {.place = atom.x[0],
          .velocity = atom.v[0],
          .spin = atom.omega[0],
          .force = atom.f[0],
          .torque = atom.torque[0],
          .mass = atom.rmass,
          .radius = atom.radius};
}

}  // namespace

bool FixNveSphere::plain() const {
  return igroup == 0 && igroup != atom->firstgroup && extra == 0 && !useAM_ && atom->rmass && domain->dimension == 3;
}

void FixNveSphere::initial_integrate(int virials) {
  if (!plain()) return FixNVESphere::initial_integrate(virials);
  if (atom->nlocal > 0) kick_and_move(arrays_of(*atom), static_cast<std::size_t>(atom->nlocal), dtf, dtv);
}

void FixNveSphere::final_integrate() {
  if (!plain()) return FixNVESphere::final_integrate();
  if (atom->nlocal > 0) kick(arrays_of(*atom), static_cast<std::size_t>(atom->nlocal), dtf);
}

bool FixGravity::plain() const {
  return igroup == 0 && varflag == 0 && atom->sphere_flag && atom->rmass && !fm && !fix_relax;
}

void FixGravity::post_force(int virials) {
  if (!plain()) return LAMMPS_NS::FixGravity::post_force(virials);
  if (atom->nlocal > 0) weigh(arrays_of(*atom), static_cast<std::size_t>(atom->nlocal), {xacc, yacc, zacc});
}

double FixGravity::compute_scalar() {
  if (!plain()) return LAMMPS_NS::FixGravity::compute_scalar();
  double energy = 0.0;
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* x = atom->x[i];
    energy -= atom->rmass[i] * (xacc * x[0] + yacc * x[1] + zacc * x[2]);
  }
  MPI_Allreduce(MPI_IN_PLACE, &energy, 1, MPI_DOUBLE, MPI_SUM, world);
  return energy;
}

}  // namespace granary::dem
