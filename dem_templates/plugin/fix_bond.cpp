#include "dem_templates/plugin/fix_bond.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <cmath>

#include <atom.h>
#include <comm.h>
#include <domain.h>
#include <force.h>
#include <modify.h>
#include <neighbor.h>
#include <pair_gran.h>
#include <update.h>

#include "dem_templates/plugin/bond/stability.hpp"
#include "dem_templates/plugin/contacts.hpp"
#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_guard.hpp"
#include "dem_templates/plugin/fix_words.hpp"
#include "dem_templates/plugin/gather.hpp"

namespace granary::dem {
namespace {

constexpr std::size_t kLoad = 6;  // a force and a torque

}  // namespace

FixBond::FixBond(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : Fix(lammps, narg, arg) {
  FixArguments arguments(fix_words(narg, arg), bond_keywords());
  settings_ = read_bond_settings(arguments);
  end_if_failed(world, arguments.status());

  vector_flag = 1;
  size_vector = 4;
  global_freq = 1;
  extvector = 0;
  create_attribute = 1;
  restart_global = 1;
  restart_peratom = 1;
  comm_forward = 2;
  comm_reverse = static_cast<int>(std::max(kLoad, BondStiffness::kNumbers));
  force_reneighbor = 1;
  next_reneighbor = -1;
  grow_arrays(atom->nmax);
  atom->add_callback(0);
  atom->add_callback(1);
}

FixBond::~FixBond() {
  atom->delete_callback(id, 0);
  atom->delete_callback(id, 1);
  leave_walls();
}

int FixBond::setmask() {
  return LAMMPS_NS::FixConst::PRE_EXCHANGE | LAMMPS_NS::FixConst::POST_FORCE | LAMMPS_NS::FixConst::POST_RUN;
}

void FixBond::refuse(const std::string& why) const {
  end_program(world, static_cast<int>(Exit::bad_input),
              "fix " + std::string(id) + " (granary/bond): " + why + " See docs/dem_styles.md.");
}

void FixBond::init() {
  if (!atom->sphere_flag || !atom->radius || !atom->rmass) refuse("needs spheres: 'atom_style granular'.");
  if (atom->map_style != 1) refuse("needs 'atom_modify map array'.");
  if (!dynamic_cast<LAMMPS_NS::PairGran*>(force->pair)) refuse("needs a pair_style gran.");
  if (force->newton_pair != 0) refuse("needs 'newton off'.");
  if (settings_.gap > neighbor->skin)
    refuse(
        fmt::format("'gap' is {} m, but the neighbour lists reach only {} m beyond touching. Take a 'neighbor' of "
                    "at least the gap.",
                    settings_.gap, neighbor->skin));
  for (int f = 0; f < modify->nfix; ++f)
    if (const auto* other = dynamic_cast<FixBond*>(modify->fix[f]); other && other != this)
      refuse("there may be only one fix granary/bond.");
  if (watching()) hear_walls();
}

void FixBond::join(int particle, double agglomerate) {
  BondPage& page = book_.page(static_cast<std::size_t>(particle));
  page.agglomerate = agglomerate;
  page.waiting = 1.0;
}

double FixBond::largest_agglomerate() const {
  double largest = 0.0;
  for (int i = 0; i < atom->nlocal; ++i)
    largest = std::max(largest, book_.page(static_cast<std::size_t>(i)).agglomerate);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, world);
  return largest;
}

void FixBond::setup(int) {
  if (settings_.whole_group && !grouped_)
    for (int i = 0; i < atom->nlocal; ++i)
      if (atom->mask[i] & groupbit) join(i, 1.0);
  grouped_ = true;
  fragments_old_ = true;
  new_list();
  end_if_failed(world, check_time_step());
  push(true);

  const double wait = settings_.create - dem_time(*lmp);
  next_reneighbor = wait > 0.0 ? update->ntimestep + static_cast<long>(std::ceil(wait / update->dt - 1e-9)) : -1;
  if (watching()) start_telling();
}

void FixBond::post_force(int) {
  if (neighbor->ago == 0) new_list();
  push(false);
  if (!watching()) return;
  const auto step = static_cast<long>(update->ntimestep);
  const bool sample_now = settings_.every > 0 && step % settings_.every == 0;
  if (step % settings_.look == 0) look_at_pairs();
  if (step % settings_.look == 0 || sample_now) tell_breaks();
  if (sample_now) sample();
}

void FixBond::post_run() {
  if (!watching()) return;
  tell_breaks();
  double last = history_.last_sample();
  MPI_Bcast(&last, 1, MPI_DOUBLE, 0, world);
  if (last < static_cast<double>(update->ntimestep)) sample();
}

// ---- which particles are bonded ----

// The neighbour list has just been made: the numbers of the particles are new.
void FixBond::new_list() {
  share_agglomerates();
  const bool made = make_bonds_if_due();
  link();
  drop_lost_partners();
  if (made) end_if_failed(world, check_time_step());
  close_pairs_.clear();
  if (!watching()) return;
  if (made) history_.start(survey());
  if (fragments_old_) number_fragments();
  for_each_listed_pair(*lmp, [this](int i, int j, int) {
    const double a = agglomerate_[static_cast<std::size_t>(i)], b = agglomerate_[static_cast<std::size_t>(j)];
    const bool strangers = a != b || a == 0.0;
    if (strangers || fragment_of(i) != fragment_of(j)) close_pairs_.push_back({i, j, strangers ? 1.0 : kOwnDebris});
  });
}

void FixBond::share_agglomerates() {
  const auto n = static_cast<std::size_t>(atom->nlocal + atom->nghost);
  agglomerate_.assign(n, 0.0);
  waiting_.assign(n, 0.0);
  for (std::size_t i = 0; i < static_cast<std::size_t>(atom->nlocal); ++i) {
    agglomerate_[i] = book_.page(i).agglomerate;
    waiting_[i] = book_.page(i).waiting;
  }
  comm->forward_comm_fix(this);
}

// LIGGGHTS' map ends at the largest tag there is, and goes on naming places of particles that were lost.
int FixBond::place_of(double tag) const {
  if (tag > atom->map_tag_max) return -1;
  const int place = atom->map(static_cast<int>(tag));
  const bool there = place >= 0 && place < atom->nlocal + atom->nghost && atom->tag[place] == static_cast<int>(tag);
  return there ? place : -1;
}

// A bond is kept by the end with the lower tag, on the rank where that one lives.
void FixBond::link() {
  rows_to_book();
  links_.clear();
  rows_.clear();
  for (int i = 0; i < atom->nlocal; ++i) {
    std::vector<Bond>& bonds = book_.page(static_cast<std::size_t>(i)).bonds;
    std::erase_if(bonds, [](const Bond& bond) { return bond.broken(); });
    for (Bond& bond : bonds) {
      const int j = domain->closest_image(i, place_of(bond.partner));
      const BondEnd near{atom->radius[i], atom->rmass[i]};
      const BondEnd far = j < 0 ? near : BondEnd{atom->radius[j], atom->rmass[j]};
      links_.push_back({i, j, &bond});
      rows_.add(bond, bond_section(settings_.material, bond.radius, near, far));
    }
  }
}

void FixBond::rows_to_book() {
  if (!rows_ahead_) return;
  rows_ahead_ = false;
  for (std::size_t k = 0; k < links_.size(); ++k) rows_.copy_state(k, *links_[k].bond);
}

// A partner that is not here has left the simulation, and its bonds with it; or it is too far away.
void FixBond::drop_lost_partners() {
  std::vector<double> missing;
  for (const Link& link : links_)
    if (link.j < 0) missing.push_back(link.bond->partner);
  int any = missing.empty() ? 0 : 1;
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, world);
  if (!any) return;

  double far_away = 0.0;
  for (const double tag : gather_all(world, missing)) {
    const int here = place_of(tag);
    if (here >= 0 && here < atom->nlocal) far_away = tag;
  }
  MPI_Allreduce(MPI_IN_PLACE, &far_away, 1, MPI_DOUBLE, MPI_MAX, world);
  if (far_away > 0.0)
    refuse(
        fmt::format("at step {} a bond of particle {} reaches farther than the ranks tell each other of their "
                    "particles. Give 'communicate single vel yes cutoff LENGTH' a length above that of the longest "
                    "bond, or let the bonds break earlier.",
                    update->ntimestep, static_cast<long>(far_away)));
  for (int i = 0; i < atom->nlocal; ++i)
    std::erase_if(book_.page(static_cast<std::size_t>(i)).bonds,
                  [this](const Bond& bond) { return place_of(bond.partner) < 0; });
  link();
}

bool FixBond::make_bonds_if_due() {
  if (dem_time(*lmp) < settings_.create - 1e-6 * update->dt) return false;
  int waiting = 0;
  for (int i = 0; i < atom->nlocal && !waiting; ++i) waiting = waiting_[static_cast<std::size_t>(i)] > 0.0 ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &waiting, 1, MPI_INT, MPI_MAX, world);
  if (!waiting) return false;
  make_bonds();
  fragments_old_ = true;
  return true;
}

void FixBond::make_bonds() {
  for_each_pair(*lmp, [this](int i, int j, double distance2, double touching2) {
    const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
    if (agglomerate_[a] != agglomerate_[b] || agglomerate_[a] == 0.0 || waiting_[a] == 0.0 || waiting_[b] == 0.0)
      return;
    if (!(atom->mask[i] & atom->mask[j] & groupbit)) return;
    const double distance = std::sqrt(distance2);
    if (distance - std::sqrt(touching2) > settings_.gap) return;
    const int owner = atom->tag[i] < atom->tag[j] ? i : j, other = owner == i ? j : i;
    if (owner >= atom->nlocal) return;
    std::vector<Bond>& bonds = book_.page(static_cast<std::size_t>(owner)).bonds;
    const auto partner = static_cast<double>(atom->tag[other]);
    if (std::any_of(bonds.begin(), bonds.end(), [&](const Bond& bond) { return bond.partner == partner; })) return;
    bonds.push_back(
        {.partner = partner,
         .radius = settings_.bond_radius(atom->radius[i], atom->radius[j]),
         .length = distance,
         .strength = bond_strength(settings_.scatter, settings_.spread, settings_.seed, atom->tag[i], atom->tag[j]),
         .normal = (1.0 / distance) * (vector_of(atom->x[other]) - vector_of(atom->x[owner]))});
  });
  for (int i = 0; i < atom->nlocal; ++i) {
    BondPage& page = book_.page(static_cast<std::size_t>(i));
    page.waiting = 0.0;
    std::sort(page.bonds.begin(), page.bonds.end(), [](const Bond& a, const Bond& b) { return a.partner < b.partner; });
  }
}

Status FixBond::check_time_step() {
  clear_numbers(BondStiffness::kNumbers);
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const auto& [i, j, bond] = links_[k];
    const BondSection section = rows_.section(k);
    BondStiffness::add(section, bond->normal, section.share * bond->length, numbers_of(i));
    BondStiffness::add(section, bond->normal, (1.0 - section.share) * bond->length, numbers_of(j));
  }
  numbers_home();
  double frequency2 = 0.0;
  for (int i = 0; i < atom->nlocal; ++i)
    frequency2 = std::max(frequency2, BondStiffness::frequency2(numbers_of(i), {atom->radius[i], atom->rmass[i]}));
  MPI_Allreduce(MPI_IN_PLACE, &frequency2, 1, MPI_DOUBLE, MPI_MAX, world);
  const double longest = longest_bond_step(frequency2, settings_.material.damping);
  if (frequency2 == 0.0 || update->dt <= longest) return {};
  return Error{
      fmt::format("fix {} (granary/bond): the time step {:.3g} s is too long for the bonds, which are stable "
                  "below {:.3g} s. Take a time step of {:.2g} s, or softer bonds. See docs/dem_styles.md.",
                  id, update->dt, longest, 0.8 * longest)};
}

// ---- forces ----

// Each bond is worked out once, on one rank; what it does to an end that is a ghost here is sent home.
void FixBond::clear_numbers(std::size_t n) {
  n_numbers_ = n;
  numbers_.assign(static_cast<std::size_t>(atom->nlocal + atom->nghost) * n, 0.0);
}

void FixBond::numbers_home() {
  if (comm->nprocs > 1 || domain->xperiodic || domain->yperiodic || domain->zperiodic) comm->reverse_comm_fix(this);
}

Vector3 FixBond::between(const Link& link) const { return vector_of(atom->x[link.j]) - vector_of(atom->x[link.i]); }

void FixBond::push(bool frozen) {
  summed_step_ = -1;
  rows_ahead_ = rows_ahead_ || !frozen;
  std::vector<std::size_t> broken;
  BondRows::Block& block = block_;
  clear_numbers(kLoad);
  // LIGGGHTS' arrays are whole, three by three; without particles there may be none.
  const bool any = !links_.empty();
  const double *x = any ? atom->x[0] : nullptr, *v = any ? atom->v[0] : nullptr, *spin = any ? atom->omega[0] : nullptr;
  for (std::size_t first = 0; first < links_.size(); first += BondRows::kBlock) {
    const std::size_t n = std::min(BondRows::kBlock, links_.size() - first);
    for (std::size_t k = 0; k < n; ++k) {
      const auto near = 3 * static_cast<std::size_t>(links_[first + k].i);
      const auto far = 3 * static_cast<std::size_t>(links_[first + k].j);
#pragma GCC unroll 3
      for (std::size_t d = 0; d < 3; ++d) {
        block.motion[d][k] = x[far + d] - x[near + d];
        block.motion[3 + d][k] = v[far + d] - v[near + d];
        block.motion[6 + d][k] = spin[near + d];
        block.motion[9 + d][k] = spin[far + d];
      }
    }
    rows_.advance(settings_.material, update->dt, frozen, first, block);
    for (std::size_t k = 0; k < n; ++k) {
      if (block.overload[k] >= 1.0 && !frozen) {
        break_bond(first + k, block.tension[k]);
        broken.push_back(first + k);
        continue;
      }
      double *const near = numbers_of(links_[first + k].i), *const far = numbers_of(links_[first + k].j);
#pragma GCC unroll 3
      for (std::size_t d = 0; d < 3; ++d) {
        near[d] += block.load[d][k];
        near[3 + d] += block.load[3 + d][k];
        far[d] -= block.load[d][k];
        far[3 + d] += block.load[6 + d][k];
      }
    }
  }
  numbers_home();
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* sum = numbers_of(i);
    for (std::size_t d = 0; d < 3; ++d) {
      atom->f[i][d] += sum[d];
      atom->torque[i][d] += sum[3 + d];
    }
  }
  for (auto k = broken.rbegin(); k != broken.rend(); ++k) {
    links_[*k] = links_.back();
    links_.pop_back();
    rows_.remove(*k);
  }
}

// A radius of 0 marks the bond as broken, until the next neighbour list.
void FixBond::break_bond(std::size_t k, double tension) {
  const auto& [i, j, bond] = links_[k];
  const BondSection section = rows_.section(k);
  rows_.copy_state(k, *bond);
  ++broken_here_;
  released_here_ += bond_energy(section, tension, *bond);
  bond->radius = 0.0;
  if (!watching()) return;
  const BondBreak how = bond_break(settings_.material, bond_stress(section, tension, *bond));
  breaks_.push_back({.step = static_cast<double>(update->ntimestep),
                     .time = dem_time(*lmp),
                     .agglomerate = static_cast<Tag>(agglomerate_[static_cast<std::size_t>(i)]),
                     .tag = atom->tag[i],
                     .far_tag = atom->tag[j],
                     .place = vector_of(atom->x[i]) + section.share * between(links_[k]),
                     .mode = how.mode,
                     .stress = how.stress});
}

double FixBond::compute_vector(int n) {
  const auto step = static_cast<long>(update->ntimestep);
  if (summed_step_ != step) {
    double energy = 0.0;
    rows_to_book();
    for (std::size_t k = 0; k < links_.size(); ++k) {
      const double stretch = norm(between(links_[k])) - links_[k].bond->length;
      const BondSection section = rows_.section(k);
      energy += bond_energy(section, section.normal * stretch, *links_[k].bond);
    }
    summed_ = {static_cast<double>(links_.size()), broken_here_, energy, released_here_};
    MPI_Allreduce(MPI_IN_PLACE, summed_.data(), static_cast<int>(summed_.size()), MPI_DOUBLE, MPI_SUM, world);
    summed_step_ = step;
  }
  return summed_[static_cast<std::size_t>(n)];
}

}  // namespace granary::dem
