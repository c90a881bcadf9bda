#include "dem_templates/plugin/pair_touching.hpp"

#include <utility>

#include <atom.h>
#include <modify.h>
#include <neigh_list.h>

#include "dem_templates/plugin/cell_neighbor.hpp"
#include "dem_templates/plugin/contacts.hpp"

namespace granary::dem {

bool PairTouching::only_touching_matter() {
  return neighbor->contactDistanceFactor <= 1.0 && !storeSumDelta() && atom->radvary_flag == 0 &&
         atom->sphere_flag != 0 && modify->n_fixes_style("insert/stream/predefined") == 0;
}

void PairTouching::start() {
  listed_.clear();
  for_each_listed_pair(*lmp, [this](int i, int j) { listed_.push_back({i, j}); });
  near_.start(listed_, atom->nlocal > 0 ? atom->x[0] : nullptr, atom->radius, static_cast<std::size_t>(atom->nlocal),
              neighbor->skin);
}

// The list is a shorter one only as long as LIGGGHTS works out the forces.
void PairTouching::compute_force(int energy, int virials, int add) {
  if (!list || atom->nlocal == 0 || !only_touching_matter()) return PairGranProxy::compute_force(energy, virials, add);
  const CellNeighbor& lists = cell_neighbor(*lmp);
  if (started_ != lists.n_built()) start();
  started_ = lists.n_built();
  std::vector<int>& touching = near_.touching(atom->x[0], lists.moved());
  const int all = std::exchange(list->inum, static_cast<int>(touching.size()));
  int* const numbers = std::exchange(list->ilist, touching.data());
  PairGranProxy::compute_force(energy, virials, add);
  list->inum = all;
  list->ilist = numbers;
}

}  // namespace granary::dem
