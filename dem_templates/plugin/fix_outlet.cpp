#include "dem_templates/plugin/fix_outlet.hpp"

#include <mpi.h>

#include <atom.h>
#include <atom_vec.h>
#include <domain.h>
#include <modify.h>
#include <region.h>

#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_tally.hpp"
#include "dem_templates/plugin/fix_words.hpp"
#include "dem_templates/plugin/input/fix_arguments.hpp"

namespace granary::dem {

FixOutlet::FixOutlet(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : Fix(lammps, narg, arg) {
  FixArguments arguments(fix_words(narg, arg), {{"region"}});
  region_ = arguments.text("region");
  end_if_failed(world, arguments.status());
}

int FixOutlet::setmask() { return LAMMPS_NS::FixConst::PRE_EXCHANGE; }

void FixOutlet::init() {
  if (domain->find_region(region_.c_str()) < 0)
    end_if_failed(world, Error{"fix " + std::string(id) + " (granary/outlet): there is no region '" + region_ +
                               "'. Define it before the run. See docs/dem_styles.md."});
}

// Here the contact histories are with the particles, the ghosts are about to be made anew: the one place where
// particles may go.
void FixOutlet::pre_exchange() {
  LAMMPS_NS::Region& region = *domain->regions[domain->find_region(region_.c_str())];
  long gone = 0;
  for (int i = 0; i < atom->nlocal;) {
    if (!(atom->mask[i] & groupbit) || !region.match(atom->x[i])) {
      ++i;
      continue;
    }
    for (int f = 0; f < modify->nfix; ++f)
      if (auto* tally = dynamic_cast<FixTally*>(modify->fix[f])) tally->leaves(i);
    atom->avec->copy(atom->nlocal - 1, i, 1);
    --atom->nlocal;
    ++gone;
  }
  left_ += gone;

  long gone_everywhere = 0;
  MPI_Allreduce(&gone, &gone_everywhere, 1, MPI_LONG, MPI_SUM, world);
  if (gone_everywhere == 0) return;
  atom->natoms -= gone_everywhere;
  if (atom->map_style) {
    atom->nghost = 0;
    atom->map_init();
    atom->map_set();
  }
}

}  // namespace granary::dem
