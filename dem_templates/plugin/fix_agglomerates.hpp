// fix ID GROUP granary/agglomerates: puts whole agglomerates into the box, once, when the next run starts. Packing and
// placing are bond/agglomerate.hpp; here they meet LIGGGHTS. Syntax: docs/dem_styles.md.
#pragma once

#include <string>
#include <vector>

#include <fix.h>

#include "dem_templates/plugin/bond/agglomerate.hpp"

namespace granary::dem {

class FixAgglomerates : public LAMMPS_NS::Fix {
 public:
  FixAgglomerates(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);

  // What LIGGGHTS calls.
  int setmask() override;
  void setup_pre_exchange() override;
  /// LIGGGHTS' cut-offs are set before the particles are there.
  double max_rad(int type) override;
  double min_rad(int type) override;
  int min_type() override { return type_; }
  int max_type() override { return type_; }

 private:
  Agglomerate spheres_there() const;
  std::vector<Agglomerate> placed() const;
  void insert(const std::vector<Agglomerate>& agglomerates);
  [[noreturn]] void refuse(const Error& why) const;

  std::string space_, bond_;
  std::vector<std::string> walls_, meshes_;
  int type_ = 1;
  double density_ = 0.0;
  Placing placing_;
  std::vector<Agglomerate> shapes_;
  bool done_ = false;
};

}  // namespace granary::dem
