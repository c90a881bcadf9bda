#include "dem_templates/plugin/cell_neighbor.hpp"

#include <algorithm>

#include <atom.h>
#include <error.h>
#include <fix_contact_history.h>
#include <lammps.h>
#include <modify.h>
#include <neigh_list.h>

namespace granary::dem {
namespace {

constexpr const char* kOverflow = "Neighbor list overflow, boost neigh_modify one";  // as LIGGGHTS says it

double distance2(const double* a, const double* b) {
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

}  // namespace

void CellNeighbor::choose_build(int index, LAMMPS_NS::NeighRequest* request) {
  Neighbor::choose_build(index, request);
  if (pair_build[index] == &CellNeighbor::granular_bin_no_newton && includegroup == 0)
    pair_build[index] = static_cast<PairPtr>(&CellNeighbor::build_by_cells);
}

void CellNeighbor::build(int topology) {
  ++n_built_;
  moved_ = std::numeric_limits<double>::infinity();
  Neighbor::build(topology);
}

// Meshes that LIGGGHTS moves find the particles near them through its own bins.
void CellNeighbor::build_by_cells(LAMMPS_NS::NeighList* list) {
  if (modify->n_fixes_style("neighlist/mesh") > 0) bin_atoms();
  const int n_own = atom->nlocal, n = n_own + atom->nghost;
  int* const count = list->numneigh;
  std::fill_n(count, n_own, 0);
  list->inum = n_own;
  list->ipage->reset();
  const std::vector<ListedPair>& pairs =
      cells_.find(n > 0 ? atom->x[0] : nullptr, atom->radius, static_cast<std::size_t>(n_own),
                  static_cast<std::size_t>(n), contactDistanceFactor, skin);
  const auto excluded = [this](const ListedPair& pair) {
    const auto [i, j] = pair;
    return exclude && exclusion(i, j, atom->type[i], atom->type[j], atom->mask, atom->molecule);
  };

  for (const ListedPair& pair : pairs)
    if (!excluded(pair)) ++count[pair.i];
  for (int i = 0; i < n_own; ++i) {
    list->ilist[i] = i;
    list->firstneigh[i] = list->ipage->get(count[i]);
    if (!list->firstneigh[i]) error->one(FLERR, kOverflow);
    count[i] = 0;
  }
  for (const ListedPair& pair : pairs)
    if (!excluded(pair)) list->firstneigh[pair.i][count[pair.i]++] = pair.j;
  if (list->fix_history) hand_over_history(*list);
}

void CellNeighbor::hand_over_history(LAMMPS_NS::NeighList& list) {
  LAMMPS_NS::FixContactHistory& before = *list.fix_history;
  LAMMPS_NS::NeighList& history = *list.listgranhistory;
  const int n_values = history.dnum;
  history.ipage->reset();
  history.dpage->reset();
  for (int i = 0; i < list.inum; ++i) {
    const int n = list.numneigh[i];
    int* const flag = history.firstneigh[i] = history.ipage->get(n);
    double* const values = history.firstdouble[i] = history.dpage->get(n * n_values);
    if (!flag || !values) error->one(FLERR, kOverflow);
    std::fill_n(flag, n, 0);
    std::fill_n(values, n * n_values, 0.0);
    const int n_partners = before.n_partner(i);
    for (int k = 0; k < n && n_partners > 0; ++k) {
      const int j = list.firstneigh[i][k];
      const double touching = (atom->radius[i] + atom->radius[j]) * contactDistanceFactor;
      if (distance2(atom->x[i], atom->x[j]) >= touching * touching) continue;
      int partner = 0;
      while (partner < n_partners && before.partner(i, partner) != atom->tag[j]) ++partner;
      if (partner == n_partners) continue;
      flag[k] = 1;
      std::copy_n(before.contacthistory(i, partner), n_values, values + k * n_values);
    }
  }
}

void use_cell_neighbor(LAMMPS_NS::LAMMPS& lammps) {
  delete lammps.neighbor;
  lammps.neighbor = new CellNeighbor(&lammps);
}
CellNeighbor& cell_neighbor(LAMMPS_NS::LAMMPS& lammps) { return static_cast<CellNeighbor&>(*lammps.neighbor); }

}  // namespace granary::dem
