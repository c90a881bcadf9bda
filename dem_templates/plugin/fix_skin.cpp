#include "dem_templates/plugin/fix_skin.hpp"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <atom.h>
#include <comm.h>
#include <update.h>

#include <fmt/format.h>

#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_words.hpp"
#include "dem_templates/plugin/input/fix_arguments.hpp"
#include "dem_templates/plugin/skin/skin_trial.hpp"

namespace granary::dem {

FixSkin::FixSkin(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : Fix(lammps, narg, arg) {
  FixArguments arguments(fix_words(narg, arg), {{"speed"}});
  least_speed_ = arguments.number_or("speed", 0.0, FixArguments::Range::not_negative());
  end_if_failed(world, arguments.status());
  scalar_flag = vector_flag = 1;
  size_vector = 1;
  extvector = 0;
  global_freq = 1;
}

double FixSkin::compute_vector(int) {
  const double skin = compute_scalar();
  return skin + largest_diameter_;
}

double FixSkin::compute_scalar() {
  if (tried_step_ == static_cast<long>(update->ntimestep)) return skin_;
  tried_step_ = static_cast<long>(update->ntimestep);
  double most[2] = {least_speed_, 0.0};  // speed, radius
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* v = atom->v[i];
    most[0] = std::max(most[0], std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
    most[1] = std::max(most[1], atom->radius[i]);
  }
  MPI_Allreduce(MPI_IN_PLACE, most, 2, MPI_DOUBLE, MPI_MAX, world);
  largest_diameter_ = 2.0 * most[1];
  std::vector<Sphere> particles;
  for (int i = 0; i < atom->nlocal; ++i)
    particles.push_back({{atom->x[i][0], atom->x[i][1], atom->x[i][2]}, atom->radius[i], 0.0, 0.0});
  auto tried = try_skins(particles, most[1], most[0], update->dt);

  std::vector<double> sums{static_cast<double>(particles.size())};
  for (const SkinCost& one : tried) sums.push_back(one.pairs);
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, world);
  for (std::size_t k = 0; k < tried.size(); ++k) tried[k].pairs = sums[k + 1];
  const double best = skin_ = best_skin(tried, sums[0]);
  if (comm->me == 0 && logfile) {
    std::string said = fmt::format("granary/skin: {:.3g} m is best; work of a step over the best:", best);
    const auto cost_of = [&](double skin) {
      for (const SkinCost& one : tried)
        if (one.skin == skin) return one.cost(sums[0]);
      return 1.0;
    };
    for (const SkinCost& one : tried)
      said += fmt::format(" {:.3g} m {:.2f},", one.skin, one.cost(sums[0]) / cost_of(best));
    said.back() = '\n';
    std::fputs(said.c_str(), logfile);
  }
  return best;
}

}  // namespace granary::dem
