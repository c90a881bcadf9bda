#include "dem_templates/plugin/fix_resize.hpp"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <numbers>
#include <set>

#include <atom.h>
#include <atom_vec.h>
#include <comm.h>
#include <domain.h>
#include <irregular.h>
#include <modify.h>

#include <fmt/format.h>

#include "common/json/io.hpp"
#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_words.hpp"
#include "dem_templates/plugin/input/fix_arguments.hpp"
#include "dem_templates/plugin/machine_space.hpp"

namespace granary::dem {
namespace {

using Range = FixArguments::Range;

double seconds_since_1970() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

double volume_of(double radius) { return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius; }

}  // namespace

FixResize::FixResize(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : Fix(lammps, narg, arg) {
  FixArguments arguments(fix_words(narg, arg), {{"population"},
                                                {"axis"},
                                                {"space"},
                                                {"mesh", 1, true},
                                                {"walls", 1, true},
                                                {"type"},
                                                {"report"},
                                                {"seed"},
                                                {"overlap"},
                                                {"sweeps"}});
  const std::string file = arguments.text("population");
  options_.axis = arguments.axis("axis");
  space_ = arguments.text("space");
  for (const auto& mesh : arguments.all("mesh")) meshes_.push_back(mesh[0]);
  for (const auto& walls : arguments.all("walls")) walls_.push_back(walls[0]);
  report_ = arguments.text_or("report", "");
  type_ = static_cast<int>(arguments.integer_or("type", 1, Range::between(1, atom->ntypes)));
  options_.seed = static_cast<std::uint64_t>(arguments.integer_or("seed", 1, Range::not_negative()));
  options_.overlap = arguments.number_or("overlap", options_.overlap, Range{1e-6, 0.5, true, true});
  options_.sweeps = static_cast<int>(arguments.integer_or("sweeps", options_.sweeps, Range::between(0, 1e7)));
  nevery = 10;
  if (igroup != 0) arguments.problem("resizes all particles: its group must be 'all'.");
  end_if_failed(world, arguments.status());

  auto population = read_population(file);
  end_if_failed(world, population ? Status{} : Status(population.error()));
  population_ = std::move(population).value();
}

int FixResize::setmask() {
  return LAMMPS_NS::FixConst::PRE_EXCHANGE | LAMMPS_NS::FixConst::END_OF_STEP | LAMMPS_NS::FixConst::POST_RUN;
}

void FixResize::init() {
  if (!atom->tag_enable || !atom->radius_flag) refuse(Error{"needs atom_style granular, with tags."});
}

double FixResize::max_rad(int) { return 0.5 * population_.largest_diameter(); }

void FixResize::setup_pre_exchange() {
  if (done_) return;
  done_ = true;

  before_ = measure();
  const std::vector<Particle> particles = gather_particles();
  double largest = population_.largest_diameter();
  for (const Particle& particle : particles) largest = std::max(largest, particle.diameter);
  auto space = machine_space(*lmp, space_, meshes_, walls_, largest);
  if (!space) refuse(space.error());
  auto plan = plan_resize(particles, population_, **space, options_);
  if (!plan) refuse(plan.error());
  apply(*plan);

  after_ = measure();
  largest_energy_ = after_.energy;
  overlap_before_ = plan->overlap_before;
  overlap_resized_ = plan->overlap_resized;
  overlap_ = plan->overlap;
  sweeps_ = plan->sweeps;
  const std::string said =
      fmt::format("granary/{}; together {} -> {} particles, {:.6g} -> {:.6g} m^3, kinetic energy {:.4g} -> {:.4g} J\n",
                  describe(*plan, population_), before_.particles, after_.particles, before_.volume, after_.volume,
                  before_.energy, after_.energy);
  for (FILE* out : {screen, logfile})
    if (comm->me == 0 && out) std::fputs(said.c_str(), out);
}

// Squeezed particles give their energy back within a contact time: looks are closer than that.
void FixResize::end_of_step() {
  largest_energy_ = std::max(largest_energy_, measure().energy);
  if (first_steps_ == 0.0) first_steps_ = seconds_since_1970();
}

void FixResize::post_run() { end_if_failed(world, write_report()); }

Status FixResize::write_report() const {
  if (report_.empty() || comm->me != 0) return {};
  const auto state = [](const State& s) {
    return json::Value::object({{"particles", static_cast<std::int64_t>(s.particles)},
                                {"volume_m3", s.volume},
                                {"kinetic_energy_J", s.energy}});
  };
  return json::write_file(report_, json::Value::object({{"format", "granary-resize-1"},
                                                        {"asked_volume_m3", population_.volume()},
                                                        {"before", state(before_)},
                                                        {"after", state(after_)},
                                                        {"overlap_before", overlap_before_},
                                                        {"overlap_resized", overlap_resized_},
                                                        {"overlap_left", overlap_},
                                                        {"sweeps", sweeps_},
                                                        {"largest_kinetic_energy_J", largest_energy_},
                                                        {"first_steps_unix_s", first_steps_}}));
}

std::vector<Particle> FixResize::gather_particles() const {
  constexpr std::size_t kNumbers = 5;
  std::vector<double> mine;
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* x = atom->x[i];
    mine.insert(mine.end(), {static_cast<double>(atom->tag[i]), x[0], x[1], x[2], 2.0 * atom->radius[i]});
  }
  const auto n_ranks = static_cast<std::size_t>(comm->nprocs);
  const int n_mine = static_cast<int>(mine.size());
  std::vector<int> sizes(n_ranks), starts(n_ranks, 0);
  MPI_Allgather(&n_mine, 1, MPI_INT, sizes.data(), 1, MPI_INT, world);
  for (std::size_t r = 1; r < n_ranks; ++r) starts[r] = starts[r - 1] + sizes[r - 1];
  std::vector<double> all(static_cast<std::size_t>(starts.back() + sizes.back()));
  MPI_Allgatherv(mine.data(), n_mine, MPI_DOUBLE, all.data(), sizes.data(), starts.data(), MPI_DOUBLE, world);

  std::vector<Particle> particles;
  for (std::size_t at = 0; at < all.size(); at += kNumbers)
    particles.push_back({static_cast<std::int64_t>(all[at]), {all[at + 1], all[at + 2], all[at + 3]}, all[at + 4]});
  return particles;
}

FixResize::State FixResize::measure() const {
  double sums[3] = {static_cast<double>(atom->nlocal), 0.0, 0.0};
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* v = atom->v[i];
    sums[1] += volume_of(atom->radius[i]);
    sums[2] += 0.5 * atom->rmass[i] * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_DOUBLE, MPI_SUM, world);
  return {static_cast<std::size_t>(sums[0]), sums[1], sums[2]};
}

// Contact histories are with the particles and no ghosts are needed: comm->exchange() and borders() follow.
void FixResize::apply(const ResizePlan& plan) {
  remove(plan);
  resize_kept(plan);
  insert(plan);
  atom->natoms = static_cast<LAMMPS_NS::bigint>(plan.kept.size() + plan.inserted.size());
  if (atom->map_style) {
    atom->nghost = 0;
    atom->map_init();
    atom->map_set();
  }
  // The relaxation may have carried a particle beyond the neighbouring rank.
  LAMMPS_NS::Irregular irregular(lmp);
  if (irregular.migrate_check()) irregular.migrate_atoms();

  const State got = measure();
  if (got.particles != plan.kept.size() + plan.inserted.size())
    refuse(
        Error{fmt::format("{} particles were planned but {} are there: some places lie outside the simulation box. "
                          "Make the box larger than "
                          "the region '{}'.",
                          plan.kept.size() + plan.inserted.size(), got.particles, space_)});
}

void FixResize::remove(const ResizePlan& plan) {
  const std::set<std::int64_t> gone(plan.removed.begin(), plan.removed.end());
  for (int i = 0; i < atom->nlocal;) {
    if (!gone.contains(atom->tag[i])) {
      ++i;
      continue;
    }
    atom->avec->copy(atom->nlocal - 1, i, 1);
    --atom->nlocal;
  }
}

void FixResize::resize_kept(const ResizePlan& plan) {
  std::map<std::int64_t, const Particle*> by_tag;
  for (const Particle& particle : plan.kept) by_tag[particle.tag] = &particle;
  for (int i = 0; i < atom->nlocal; ++i) {
    const Particle& particle = *by_tag.at(atom->tag[i]);
    std::copy(particle.centre.begin(), particle.centre.end(), atom->x[i]);
    atom->radius[i] = 0.5 * particle.diameter;
    atom->density[i] = population_.density;
    atom->rmass[i] = volume_of(atom->radius[i]) * population_.density;
  }
}

void FixResize::insert(const ResizePlan& plan) {
  for (const Particle& particle : plan.inserted) {
    double place[3] = {particle.centre[0], particle.centre[1], particle.centre[2]};
    if (!domain->is_in_subdomain(place)) continue;
    atom->avec->create_atom(type_, place);
    const int i = atom->nlocal - 1;
    atom->tag[i] = static_cast<int>(particle.tag);
    atom->mask[i] = 1 | groupbit;
    std::fill_n(atom->v[i], 3, 0.0);
    std::fill_n(atom->omega[i], 3, 0.0);
    atom->radius[i] = 0.5 * particle.diameter;
    atom->density[i] = population_.density;
    atom->rmass[i] = volume_of(atom->radius[i]) * population_.density;
    for (int f = 0; f < modify->nfix; ++f)
      if (modify->fix[f]->create_attribute) modify->fix[f]->set_arrays(i);
  }
}

void FixResize::refuse(const Error& why) const {
  end_program(world, static_cast<int>(why.exit), "fix " + std::string(id) + " (granary/resize): " + why.message);
}

}  // namespace granary::dem
