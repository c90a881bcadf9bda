// LIGGGHTS' neighbour lists of spheres, made faster: the same pairs, found by lists/cell_pairs.hpp.
#pragma once

#include <limits>

#include <neighbor.h>

#include "dem_templates/plugin/lists/cell_pairs.hpp"

namespace granary::dem {

/// Takes the place of LIGGGHTS' own as soon as there is one. Lists of other kinds, other styles than `bin` and
/// `neigh_modify include` are made as before. The order of a particle's neighbours is another.
class CellNeighbor : public LAMMPS_NS::Neighbor {
 public:
  explicit CellNeighbor(LAMMPS_NS::LAMMPS* lammps) : Neighbor(lammps) {}

  void build(int topology = 1) override;
  /// How often lists have been made, since the program started.
  long n_built() const { return n_built_; }
  /// How far a particle has moved at most since the lists were made, in a frame that all share; infinite where nobody
  /// says [m].
  double moved() const { return moved_; }
  /// To be said in each step, of all ranks, by who says it in one.
  void moved(double distance) { moved_ = distance; }

 protected:
  void choose_build(int index, LAMMPS_NS::NeighRequest* request) override;

 private:
  void build_by_cells(LAMMPS_NS::NeighList* list);
  /// What the pair style remembered of each pair that touched and touches still, beside the list.
  void hand_over_history(LAMMPS_NS::NeighList& list);

  long n_built_ = 0;
  double moved_ = std::numeric_limits<double>::infinity();
  CellPairs cells_;
};

/// Puts a CellNeighbor in the place of LIGGGHTS' own. Before the first command.
void use_cell_neighbor(LAMMPS_NS::LAMMPS& lammps);
/// That one.
CellNeighbor& cell_neighbor(LAMMPS_NS::LAMMPS& lammps);

}  // namespace granary::dem
