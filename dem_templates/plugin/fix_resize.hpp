// fix ID GROUP granary/resize: makes the state hold the population of a file, once, when the next run starts. What to
// do is decided in resize/; here it is done to LIGGGHTS' particles. Syntax: docs/dem_styles.md.
#pragma once

#include <string>
#include <vector>

#include <fix.h>

#include "dem_templates/plugin/resize/plan.hpp"
#include "dem_templates/plugin/resize/population.hpp"

namespace granary::dem {

class FixResize : public LAMMPS_NS::Fix {
 public:
  FixResize(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);

  // What LIGGGHTS calls.
  int setmask() override;
  void init() override;
  void setup_pre_exchange() override;
  void end_of_step() override;
  void post_run() override;
  /// LIGGGHTS' cut-offs are set before the particles grow.
  double max_rad(int type) override;
  /// Nor are there particles yet from which it would know their type.
  int min_type() override { return type_; }
  int max_type() override { return type_; }

 private:
  struct State {
    std::size_t particles = 0;
    double volume = 0.0;  ///< [m^3]
    double energy = 0.0;  ///< translational [J]
  };

  std::vector<Particle> gather_particles() const;
  State measure() const;
  void apply(const ResizePlan& plan);
  Status write_report() const;
  void remove(const ResizePlan& plan);
  void resize_kept(const ResizePlan& plan);
  void insert(const ResizePlan& plan);
  [[noreturn]] void refuse(const Error& why) const;

  std::string space_;
  std::vector<std::string> meshes_, walls_;
  int type_ = 1;
  ResizeOptions options_;
  ResizePopulation population_;
  bool done_ = false;

  // Of what was done, for the report.
  std::string report_;
  State before_, after_;
  double overlap_before_ = 0.0, overlap_resized_ = 0.0, overlap_ = 0.0;
  int sweeps_ = 0;
  double largest_energy_ = 0.0;  ///< since then, until the run ended [J]
  double first_steps_ = 0.0;     ///< when the first steps were done [s since 1970]
};

}  // namespace granary::dem
