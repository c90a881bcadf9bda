#include "dem_templates/plugin/fix_guard.hpp"

#include <mpi.h>

#include <algorithm>
#include <cmath>

#include <atom.h>
#include <comm.h>
#include <error.h>
#include <force.h>
#include <lammps.h>
#include <modify.h>
#include <pair_gran.h>
#include <signal_handling.h>
#include <update.h>

#include "common/json/io.hpp"
#include "dem_templates/plugin/contacts.hpp"
#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_words.hpp"
#include "dem_templates/plugin/input/fix_arguments.hpp"
#include "dem_templates/plugin/stop_signal.hpp"
#include "dem_templates/plugin/walls.hpp"

namespace granary::dem {

using Range = FixArguments::Range;

FixGuard::FixGuard(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : Fix(lammps, narg, arg) {
  FixArguments arguments(fix_words(narg, arg),
                         {{"file"}, {"every"}, {"restart"}, {"overlap"}, {"overlapping"}, {"energy"}, {"lost"}});
  file_ = arguments.text("file");
  restart_file_ = arguments.text_or("restart", "restart.liggghts");
  nevery = static_cast<int>(arguments.integer_or("every", 50, Range::between(1, 1e9)));
  bounds_.overlap = arguments.number_or("overlap", bounds_.overlap, Range::positive());
  bounds_.overlapping_fraction = arguments.number_or("overlapping", bounds_.overlapping_fraction, Range::fraction());
  bounds_.lost_fraction = arguments.number_or("lost", bounds_.lost_fraction, Range::fraction());
  if (arguments.has("energy")) bounds_.energy = arguments.number("energy", Range::positive());
  if (igroup != 0) arguments.problem("guards all particles: its group must be 'all'.");
  end_if_failed(world, arguments.status());

  restart_global = 1;
  clock_step_ = static_cast<long>(update->ntimestep);
  clock_time_step_ = update->dt;
}

int FixGuard::setmask() { return LAMMPS_NS::FixConst::END_OF_STEP | LAMMPS_NS::FixConst::PRE_EXCHANGE; }

void FixGuard::init() {
  if (!dynamic_cast<LAMMPS_NS::PairGran*>(force->pair))
    end_if_failed(
        world, Error{"fix " + std::string(id) + " (granary/guard): needs a pair_style gran. See docs/dem_styles.md."});
}

void FixGuard::setup(int) {
  clock_ = time();
  clock_step_ = static_cast<long>(update->ntimestep);
  clock_time_step_ = update->dt;

  // What changed between two runs (a resize) was asked for.
  balance_ = count_particles(*lmp);
  if (!started_) ever_present_ = 0;
  ever_present_ = std::max(ever_present_, balance_.present);
  started_ = true;
}

// Positions that are no numbers would send LIGGGHTS' cell lists astray: look just before they are made.
void FixGuard::pre_exchange() { check(false); }

void FixGuard::end_of_step() {
  check(true);
  if (stopping_) LAMMPS_NS::SignalHandler::request_quit = true;  // on all ranks at this step; LIGGGHTS ends its run
}

void FixGuard::check(bool with_contacts) {
  bool stop_asked = false;
  const Vitals vitals = measure(with_contacts, stop_asked);
  if (const auto divergence = find_divergence(vitals, bounds_)) end_diverged(*divergence);
  if (with_contacts && stop_asked) stopping_ = true;
}

Vitals FixGuard::measure(bool with_contacts, bool& stop_asked) {
  bool finite = true;
  double energy = 0.0;
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* x = atom->x[i];
    const double* v = atom->v[i];
    const double speed2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    finite = finite && std::isfinite(x[0] + x[1] + x[2] + speed2);
    energy += 0.5 * atom->rmass[i] * speed2;
  }
  double largest[3] = {finite ? 0.0 : 1.0, stop_requested() ? 1.0 : 0.0, 0.0}, sums[2] = {energy, 0.0};
  if (with_contacts && finite) {
    for (const double overlap : largest_overlaps()) {
      largest[2] = std::max(largest[2], overlap);
      sums[1] += overlap > bounds_.overlap ? 1.0 : 0.0;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, largest, 3, MPI_DOUBLE, MPI_MAX, world);
  MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, world);
  stop_asked = largest[1] > 0.0;

  if (with_contacts) {
    const ParticleBalance now = count_particles(*lmp);
    lost_ += now.lost_since(balance_);
    ever_present_ += now.inserted - balance_.inserted;
    balance_ = now;
  }
  return {.finite = largest[0] == 0.0,
          .overlap = largest[2],
          .overlapping = static_cast<long>(sums[1]),
          .present = balance_.present,
          .energy = sums[0],
          .lost = lost_,
          .ever_present = ever_present_};
}

std::vector<double> FixGuard::largest_overlaps() {
  std::vector<double> largest(static_cast<std::size_t>(atom->nlocal), 0.0);
  const auto note = [&](int i, double overlap) {
    if (i < atom->nlocal)
      largest[static_cast<std::size_t>(i)] = std::max(largest[static_cast<std::size_t>(i)], overlap);
  };
  const double* const radius = atom->radius;
  for_each_pair(*lmp, [&](int i, int j, double distance2, double touching2) {
    if (distance2 >= touching2) return;
    const double overlap = radius[i] + radius[j] - std::sqrt(distance2);
    note(i, overlap / radius[i]);
    note(j, overlap / radius[j]);
  });
  for (const auto& wall : find_all_walls(*lmp))
    wall->touches([&](const WallTouch& touch) { note(touch.particle, touch.overlap); });
  return largest;
}

void FixGuard::end_diverged(const Divergence& divergence) {
  std::string said = "the run diverged at " + std::to_string(time()) + " s (" + divergence.cause +
                     "): " + divergence.message + " Settings:";
  for (const std::string& setting : divergence.settings) said += " " + setting;
  Status written;
  if (comm->me == 0) {
    auto writer = json::LineWriter::append_to(file_);
    written = writer ? writer->append(divergence_line(divergence, time())) : Status(writer.error());
    if (!written) said = written.error().message + "\ngranary-dem: " + said;
  }
  end_program(world, kDivergedExit, said);
}

double FixGuard::time() const {
  return clock_ + static_cast<double>(static_cast<long>(update->ntimestep) - clock_step_) * clock_time_step_;
}

void FixGuard::write_restart(FILE* file) {
  if (comm->me != 0) return;
  const double state[2] = {time(), static_cast<double>(update->ntimestep)};
  const int size = sizeof(state);
  fwrite(&size, sizeof(int), 1, file);
  fwrite(state, sizeof(double), 2, file);
}

void FixGuard::restart(char* state) {
  const auto* values = reinterpret_cast<const double*>(state);
  clock_ = values[0];
  clock_step_ = static_cast<long>(values[1]);
}

FixGuard* find_guard(LAMMPS_NS::LAMMPS& lammps) {
  for (int i = 0; i < lammps.modify->nfix; ++i)
    if (auto* guard = dynamic_cast<FixGuard*>(lammps.modify->fix[i])) return guard;
  return nullptr;
}

double dem_time(LAMMPS_NS::LAMMPS& lammps) {
  const FixGuard* guard = find_guard(lammps);
  return guard ? guard->time() : static_cast<double>(lammps.update->ntimestep) * lammps.update->dt;
}

}  // namespace granary::dem
