#include "dem_templates/plugin/register_styles.hpp"

#include <force.h>
#include <lammps.h>
#include <modify.h>

#include "dem_templates/plugin/cell_neighbor.hpp"
#include "dem_templates/plugin/fix_agglomerates.hpp"
#include "dem_templates/plugin/fix_balance.hpp"
#include "dem_templates/plugin/fix_bond.hpp"
#include "dem_templates/plugin/fix_guard.hpp"
#include "dem_templates/plugin/fix_lists.hpp"
#include "dem_templates/plugin/fix_motion.hpp"
#include "dem_templates/plugin/fix_outlet.hpp"
#include "dem_templates/plugin/fix_resize.hpp"
#include "dem_templates/plugin/fix_skin.hpp"
#include "dem_templates/plugin/fix_tally.hpp"
#include "dem_templates/plugin/pair/fix_touch_history.hpp"
#include "dem_templates/plugin/pair/pair_touching.hpp"
#include "dem_templates/plugin/wall/fix_wall.hpp"

namespace {

// LIGGGHTS 3.8.0 keeps its table of fix styles private and has no plugin command. An explicit instantiation may name a
// private member, and a friend function defined in the template hands its address out.
template <auto Member>
struct Reach {
  friend auto fix_map_of_modify() { return Member; }
};
auto fix_map_of_modify();
template struct Reach<&LAMMPS_NS::Modify::fix_map>;

template <class Style>
LAMMPS_NS::Fix* create(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) {
  return new Style(lammps, narg, arg);
}
template <class Style>
LAMMPS_NS::Pair* create_pair(LAMMPS_NS::LAMMPS* lammps) {
  return new Style(lammps);
}

}  // namespace

namespace granary::dem {

void register_styles(LAMMPS_NS::LAMMPS& lammps) {
  auto& styles = *(lammps.modify->*fix_map_of_modify());
  styles["granary/agglomerates"] = create<FixAgglomerates>;
  styles["granary/balance"] = create<FixBalance>;
  styles["granary/bond"] = create<FixBond>;
  styles["granary/guard"] = create<FixGuard>;
  styles["granary/lists"] = create<FixLists>;
  styles["granary/outlet"] = create<FixOutlet>;
  styles["granary/resize"] = create<FixResize>;
  styles["granary/skin"] = create<FixSkin>;
  styles["granary/tally"] = create<FixTally>;
  styles["granary/wall"] = create<FixWall>;

  // LIGGGHTS' own that are done in another way.
  styles["contacthistory"] = create<FixTouchHistory>;
  styles["gravity"] = create<FixGravity>;
  styles["nve/sphere"] = create<FixNveSphere>;
  use_cell_neighbor(lammps);
  (*lammps.force->pair_map)["gran"] = create_pair<PairTouching>;
}

}  // namespace granary::dem
