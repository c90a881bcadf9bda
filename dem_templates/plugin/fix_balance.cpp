#include "dem_templates/plugin/fix_balance.hpp"

#include <mpi.h>

#include <algorithm>
#include <string>

#include <atom.h>
#include <comm.h>
#include <domain.h>
#include <force.h>
#include <modify.h>
#include <neigh_list.h>
#include <neighbor.h>
#include <pair.h>

#include "dem_templates/plugin/balance/even_cuts.hpp"
#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_words.hpp"
#include "dem_templates/plugin/input/fix_arguments.hpp"
#include "dem_templates/plugin/wall/fix_wall.hpp"

namespace granary::dem {
namespace {

constexpr std::size_t kParts = 1024;
constexpr double kTolerated = 1.02;  // of the imbalance: particles that change ranks cost, too
// Measured on the mixer: what a particle and its touch of a body cost in a step, over a listed pair.
constexpr double kParticle = 4.0, kTouch = 30.0;

}  // namespace

FixBalance::FixBalance(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : Fix(lammps, narg, arg) {
  FixArguments arguments(fix_words(narg, arg), {{"every"}});
  every_ = arguments.integer_or("every", every_, FixArguments::Range::at_least(1));
  if (igroup != 0) arguments.problem("balances all particles: its group must be 'all'.");
  end_if_failed(world, arguments.status());
  scalar_flag = 1;
  global_freq = 1;
}

int FixBalance::setmask() { return LAMMPS_NS::FixConst::PRE_EXCHANGE; }

// LIGGGHTS shares out the triangles of its own meshes by the ranks' boxes, when a run starts.
void FixBalance::init() {
  for (int f = 0; f < modify->nfix; ++f)
    if (comm->nprocs > 1 && std::string(modify->fix[f]->style).rfind("mesh/surface", 0) == 0)
      end_if_failed(world,
                    Error{"fix " + std::string(id) + " (granary/balance): does not go with fix '" + modify->fix[f]->id +
                          "' (" + modify->fix[f]->style + "). Use granary/wall. See docs/dem_styles.md."});
}

// LIGGGHTS makes its boxes, bins and exchange anew after this.
void FixBalance::setup_pre_exchange() {
  lists_ = 0;
  move_cuts();
}

void FixBalance::pre_exchange() {
  if (++lists_ % every_ != 0 || !move_cuts()) return;
  comm->setup();
  neighbor->setup_bins();
}

void FixBalance::estimate_work() {
  work_.assign(static_cast<std::size_t>(atom->nlocal), kParticle);
  const LAMMPS_NS::NeighList* list = force->pair ? force->pair->list : nullptr;
  for (int n = 0; list && n < list->inum; ++n)
    if (const int i = list->ilist[n]; i < atom->nlocal) work_[static_cast<std::size_t>(i)] += list->numneigh[i];
  for (int f = 0; f < modify->nfix; ++f)
    if (const auto* walls = dynamic_cast<const FixWall*>(modify->fix[f]))
      for (int i = 0; i < atom->nlocal; ++i)
        work_[static_cast<std::size_t>(i)] += kTouch * static_cast<double>(walls->n_touches(i));
}

std::vector<double> FixBalance::load_along(int axis) const {
  std::vector<double> load(kParts, 0.0);
  const double low = domain->boxlo[axis], scale = static_cast<double>(kParts) / domain->prd[axis];
  for (std::size_t i = 0; i < work_.size(); ++i) {
    const double part = std::clamp((atom->x[i][axis] - low) * scale, 0.0, static_cast<double>(kParts - 1));
    load[static_cast<std::size_t>(part)] += work_[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, load.data(), static_cast<int>(kParts), MPI_DOUBLE, MPI_SUM, world);
  return load;
}

bool FixBalance::move_cuts() {
  if (comm->nprocs == 1) return false;
  estimate_work();
  double* const split[3] = {comm->xsplit, comm->ysplit, comm->zsplit};
  bool moved = false;
  imbalance_ = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const int n = comm->procgrid[axis];
    if (n == 1) continue;
    const std::vector<double> load = load_along(axis), now(split[axis], split[axis] + n + 1);
    const double uneven = imbalance(load, now);
    imbalance_ *= uneven;
    if (uneven < kTolerated) continue;
    const std::vector<double> cuts = even_cuts(load, now, std::min(neighbor->cutneighmax / domain->prd[axis], 0.5 / n));
    std::copy(cuts.begin(), cuts.end(), split[axis]);
    moved = moved || cuts != now;
  }
  if (!moved) return false;
  comm->uniform = 0;
  domain->set_local_box();
  return true;
}

}  // namespace granary::dem
