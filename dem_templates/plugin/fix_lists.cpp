#include "dem_templates/plugin/fix_lists.hpp"

#include <mpi.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <atom.h>
#include <comm.h>
#include <domain.h>
#include <modify.h>
#include <neighbor.h>
#include <update.h>

#include "dem_templates/plugin/cell_neighbor.hpp"
#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_words.hpp"
#include "dem_templates/plugin/input/fix_arguments.hpp"

namespace granary::dem {
namespace {

constexpr int kNever = 1000000000;  // steps
// Rates that are tried beside the present one: by steps of so much of the fastest particle's own. The best rate of one
// list is near that of the next.
constexpr double kRateStep = 1.0 / 16.0;
constexpr std::array<double, 6> kRateSteps{-3.0, -1.0, -0.3, 0.3, 1.0, 3.0};

}  // namespace

FixLists::FixLists(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : Fix(lammps, narg, arg) {
  FixArguments arguments(fix_words(narg, arg), {{"axis"}});
  axis_ = arguments.axis("axis");
  if (igroup != 0) arguments.problem("lists all particles: its group must be 'all'.");
  end_if_failed(world, arguments.status());
  frame_ = TurningFrame(axis_);
  delay_ = neighbor->delay;
  force_reneighbor = 1;
  next_reneighbor = -1;
  scalar_flag = 1;
  global_freq = 1;
}

FixLists::~FixLists() {
  neighbor->delay = delay_;
  cell_neighbor(*lmp).moved(std::numeric_limits<double>::infinity());
}

int FixLists::setmask() { return LAMMPS_NS::FixConst::POST_INTEGRATE | LAMMPS_NS::FixConst::PRE_FORCE; }

// Meshes that LIGGGHTS moves have lists of their own, which count on its check.
void FixLists::init() {
  for (int f = 0; f < modify->nfix; ++f)
    if (std::string(modify->fix[f]->style).rfind("mesh/surface", 0) == 0)
      end_if_failed(world,
                    Error{"fix " + std::string(id) + " (granary/lists): does not go with fix '" + modify->fix[f]->id +
                          "' (" + modify->fix[f]->style + "). Use granary/wall. See docs/dem_styles.md."});
  neighbor->delay = kNever / neighbor->every * neighbor->every;
  next_reneighbor = -1;
}

void FixLists::pre_force(int) {
  if (neighbor->ago == 0) start();
}

// A particle that is sent to another rank goes one rank far, so it must not have been turned past that; and a frame
// that turns does not meet itself across a periodic boundary.
bool FixLists::may_turn() const {
  for (int d = 0; d < 3; ++d)
    if (d != axis_ && (comm->procgrid[d] > 1 || domain->periodicity[d] != 0)) return false;
  return true;
}

void FixLists::start() {
  const auto n = static_cast<std::size_t>(atom->nlocal);
  const double* const places = n > 0 ? atom->x[0] : nullptr;
  frame_.start(places, n);
  angle_ = 0.0;
  cell_neighbor(*lmp).moved(0.0);
  if (!may_turn()) return;

  const double* const velocities = n > 0 ? atom->v[0] : nullptr;
  const double lever = std::max({std::abs(domain->boxlo[(axis_ + 1) % 3]), std::abs(domain->boxhi[(axis_ + 1) % 3]),
                                 std::abs(domain->boxlo[(axis_ + 2) % 3]), std::abs(domain->boxhi[(axis_ + 2) % 3])});
  double fastest2 = frame_.largest_speeds2(places, velocities, n, std::array{0.0})[0];
  MPI_Allreduce(MPI_IN_PLACE, &fastest2, 1, MPI_DOUBLE, MPI_MAX, world);
  std::vector<double> rates{rate_, 0.0};
  for (const double steps : kRateSteps) rates.push_back(rate_ + steps * kRateStep * std::sqrt(fastest2) / lever);
  std::vector<double> speeds2 = frame_.largest_speeds2(places, velocities, n, rates);
  MPI_Allreduce(MPI_IN_PLACE, speeds2.data(), static_cast<int>(speeds2.size()), MPI_DOUBLE, MPI_MAX, world);
  rate_ = rates[static_cast<std::size_t>(std::min_element(speeds2.begin(), speeds2.end()) - speeds2.begin())];
}

void FixLists::post_integrate() {
  angle_ += rate_ * update->dt;
  const auto n = static_cast<std::size_t>(atom->nlocal);
  double moved = frame_.farthest_moved(n > 0 ? atom->x[0] : nullptr, n, angle_);
  if (comm->nprocs > 1) MPI_Allreduce(MPI_IN_PLACE, &moved, 1, MPI_DOUBLE, MPI_MAX, world);
  if (moved >= 0.5 * neighbor->skin) next_reneighbor = update->ntimestep;
  cell_neighbor(*lmp).moved(moved);
}

}  // namespace granary::dem
