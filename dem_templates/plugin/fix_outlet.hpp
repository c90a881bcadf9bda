// fix ID GROUP granary/outlet region REGION: takes out the particles that have left. See docs/dem_styles.md.
#pragma once

#include <string>

#include <fix.h>

namespace granary::dem {

class FixOutlet : public LAMMPS_NS::Fix {
 public:
  FixOutlet(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);

  int setmask() override;
  void init() override;
  void pre_exchange() override;

  /// Particles this rank has taken out so far.
  long left_here() const { return left_; }

 private:
  std::string region_;
  long left_ = 0;
};

}  // namespace granary::dem
