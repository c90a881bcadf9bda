// fix ID all granary/guard: ends a run that has diverged or was asked to stop, at one step on all ranks; keeps the DEM
// clock over restarts. Syntax: docs/dem_styles.md.
#pragma once

#include <string>
#include <vector>

#include <fix.h>

#include "dem_templates/plugin/guard/divergence.hpp"
#include "dem_templates/plugin/particle_balance.hpp"

namespace granary::dem {

class FixGuard : public LAMMPS_NS::Fix {
 public:
  FixGuard(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);

  /// The DEM clock: goes on over restarts, also with another time step [s].
  double time() const;
  bool started() const { return started_; }
  bool stopping() const { return stopping_; }
  const std::string& restart_file() const { return restart_file_; }

  // What LIGGGHTS calls.
  int setmask() override;
  void init() override;
  void setup(int) override;
  void pre_exchange() override;
  void end_of_step() override;
  void write_restart(FILE* file) override;
  void restart(char* state) override;

 private:
  void check(bool with_contacts);
  Vitals measure(bool with_contacts, bool& stop_asked);
  /// Of each particle of this rank, over its radius.
  std::vector<double> largest_overlaps();
  [[noreturn]] void end_diverged(const Divergence& divergence);

  std::string file_, restart_file_;
  Bounds bounds_;
  bool started_ = false, stopping_ = false;
  ParticleBalance balance_;  ///< at the last check
  long lost_ = 0, ever_present_ = 0;
  double clock_ = 0.0;  ///< DEM time at step clock_step_ [s]
  long clock_step_ = 0;
  double clock_time_step_ = 0.0;  ///< [s] since then
};

/// The guard of this run, or nullptr.
FixGuard* find_guard(LAMMPS_NS::LAMMPS& lammps);
/// The guard's clock; without a guard the step number times the time step [s].
double dem_time(LAMMPS_NS::LAMMPS& lammps);

}  // namespace granary::dem
