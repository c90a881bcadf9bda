#include "dem_templates/plugin/fix_bond.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <set>

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
#include "dem_templates/plugin/wall/fix_wall.hpp"

namespace granary::dem {
namespace {

constexpr std::size_t kLoad = 6;  // a force and a torque
// Debris of the same agglomerate is the cause of a break only if nothing else is: what smashed it goes on in its
// pieces.
constexpr double kOwnDebris = 1e-9;

Vector3 vector_of(const double* v) { return {v[0], v[1], v[2]}; }

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
  hear_walls(false);
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
  hear_walls(true);
}

// The walls hand over each touch of each step as they push.
void FixBond::hear_walls(bool listen) {
  std::vector<std::string> names{"particles"};
  for (int f = 0; f < modify->nfix; ++f) {
    auto* wall = dynamic_cast<FixWall*>(modify->fix[f]);
    if (!wall) continue;
    const std::size_t first = names.size();
    for (const std::string& name : wall->body_names()) names.push_back(name);
    if (!listen || !watching()) {
      wall->set_touch_listener({});
      continue;
    }
    wall->set_touch_listener([this, first](std::size_t body, int particle, double depth) {
      book_.page(static_cast<std::size_t>(particle))
          .squeeze.note(static_cast<double>(update->ntimestep), static_cast<double>(first + body), depth,
                        window_steps());
    });
  }
  history_.set_causes(names, window_steps());
}

double FixBond::window_steps() const { return settings_.cause_window / update->dt; }

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
  if (!watching()) return;
  const FragmentSurvey now = survey();
  if (comm->me == 0) {
    const auto open = [](const std::string& file, std::optional<json::LineWriter>& writer) -> Status {
      if (file.empty() || writer) return {};
      GRANARY_TRY(writer, json::LineWriter::append_to(file));
      return {};
    };
    history_.start(now);
    Status opened = open(settings_.fragments, fragments_);
    if (opened) opened = open(settings_.breaks, broken_);
    end_if_failed(world, opened);
  } else {
    end_if_failed(world, {});
  }
  double last = history_.last_sample();
  MPI_Bcast(&last, 1, MPI_DOUBLE, 0, world);
  if (last < 0.0) sample();
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
  make_bonds_if_due();
  link();
  drop_lost_partners();
  close_pairs_.clear();
  if (!watching()) return;
  if (fragments_old_) number_fragments();
  for_each_listed_pair(*lmp, [this](int i, int j, std::size_t) {
    const double a = agglomerate_[static_cast<std::size_t>(i)], b = agglomerate_[static_cast<std::size_t>(j)];
    const bool strangers = a != b || a == 0.0;
    if (strangers || fragment_of(i) != fragment_of(j)) close_pairs_.push_back({i, j, strangers ? 1.0 : kOwnDebris});
  });
}

// Every rank has all bonds at hand and finds the same.
void FixBond::number_fragments() {
  fragments_old_ = false;
  fragment_of_tag_.clear();
  const FragmentSurvey all = survey();
  BondGraph graph;
  Tag largest = 0;
  for (const auto& particle : all.particles) {
    graph.add_particle(particle.tag);
    largest = std::max(largest, particle.tag);
  }
  for (const auto& [a, b] : all.bonds) graph.add_bond(a, b);
  fragment_of_tag_.assign(static_cast<std::size_t>(largest) + 1, 0);
  for (const auto& fragment : graph.fragments())
    for (const Tag tag : fragment) fragment_of_tag_[static_cast<std::size_t>(tag)] = static_cast<int>(fragment[0]);
}

int FixBond::fragment_of(int particle) const {
  const auto tag = static_cast<std::size_t>(atom->tag[particle]);
  return tag < fragment_of_tag_.size() ? fragment_of_tag_[tag] : 0;
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

// A bond is kept by the end with the lower tag, on the rank where that one lives.
void FixBond::link() {
  rows_to_book();
  links_.clear();
  rows_.clear();
  for (int i = 0; i < atom->nlocal; ++i) {
    for (Bond& bond : book_.page(static_cast<std::size_t>(i)).bonds) {
      const int j = domain->closest_image(i, atom->map(static_cast<int>(bond.partner)));
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
    const int here = atom->map(static_cast<int>(tag));
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
                  [this](const Bond& bond) { return atom->map(static_cast<int>(bond.partner)) < 0; });
  link();
}

void FixBond::make_bonds_if_due() {
  if (dem_time(*lmp) < settings_.create - 1e-6 * update->dt) return;
  int waiting = 0;
  for (int i = 0; i < atom->nlocal && !waiting; ++i) waiting = waiting_[static_cast<std::size_t>(i)] > 0.0 ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &waiting, 1, MPI_INT, MPI_MAX, world);
  if (!waiting) return;
  make_bonds();
  fragments_old_ = true;
}

void FixBond::make_bonds() {
  for_each_pair(*lmp, [this](int i, int j, std::size_t, double distance2, double touching2) {
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
  bool broke = false;
  clear_numbers(kLoad);
  // LIGGGHTS' arrays are whole, three by three; without particles there may be none.
  const bool any = !links_.empty();
  const double *x = any ? atom->x[0] : nullptr, *v = any ? atom->v[0] : nullptr, *spin = any ? atom->omega[0] : nullptr;
  for (std::size_t first = 0; first < links_.size(); first += BondRows::kBlock) {
    const std::size_t n = std::min(BondRows::kBlock, links_.size() - first);
    for (std::size_t k = 0; k < n; ++k) {
      const auto near = 3 * static_cast<std::size_t>(links_[first + k].i);
      const auto far = 3 * static_cast<std::size_t>(links_[first + k].j);
      for (std::size_t d = 0; d < 3; ++d) {
        block_.motion[d][k] = x[far + d] - x[near + d];
        block_.motion[3 + d][k] = v[far + d] - v[near + d];
        block_.motion[6 + d][k] = spin[near + d];
        block_.motion[9 + d][k] = spin[far + d];
      }
    }
    rows_.advance(settings_.material, update->dt, frozen, first, block_);
    for (std::size_t k = 0; k < n; ++k) {
      if (block_.overload[k] >= 1.0 && !frozen) {
        break_bond(first + k, block_.tension[k]);
        broke = true;
        continue;
      }
      double *near = numbers_of(links_[first + k].i), *far = numbers_of(links_[first + k].j);
      for (std::size_t d = 0; d < 3; ++d) {
        near[d] += block_.load[d][k];
        near[3 + d] += block_.load[3 + d][k];
        far[d] -= block_.load[d][k];
        far[3 + d] += block_.load[6 + d][k];
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
  if (!broke) return;
  rows_to_book();
  for (int i = 0; i < atom->nlocal; ++i)
    std::erase_if(book_.page(static_cast<std::size_t>(i)).bonds, [](const Bond& bond) { return bond.radius == 0.0; });
  link();
}

// A radius of 0 marks the bond as broken.
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

// ---- what is told ----

// Of two particles each gives in by half the overlap: a wall that is hard lets its particle give in by all of it. So
// the depths compare as the forces do.
void FixBond::look_at_pairs() {
  const auto now = static_cast<double>(update->ntimestep);
  const auto note = [&](int i, double depth) {
    if (i < atom->nlocal)
      book_.page(static_cast<std::size_t>(i)).squeeze.note(now, 0.0, depth / atom->radius[i], window_steps());
  };
  for (const auto& [i, j, weight] : close_pairs_) {
    const Vector3 away = vector_of(atom->x[i]) - vector_of(atom->x[j]);
    const double touching = atom->radius[i] + atom->radius[j], distance2 = dot(away, away);
    if (distance2 >= touching * touching) continue;
    const double depth = 0.5 * weight * (touching - std::sqrt(distance2));
    note(i, depth);
    note(j, depth);
  }
}

void FixBond::tell_breaks() {
  int any = breaks_.empty() ? 0 : 1;
  if (comm->nprocs > 1) MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, world);
  if (!any) return;
  fragments_old_ = true;

  std::vector<double> mine;
  for (const BreakEvent& e : breaks_)
    mine.insert(mine.end(), {e.step, e.time, static_cast<double>(e.agglomerate), static_cast<double>(e.tag),
                             static_cast<double>(e.far_tag), e.place[0], e.place[1], e.place[2],
                             static_cast<double>(e.mode), e.stress});
  breaks_.clear();
  const std::vector<double> told = gather_all(world, mine);

  mine.clear();
  const double oldest = static_cast<double>(update->ntimestep - settings_.look) - window_steps();
  for (int i = 0; i < atom->nlocal; ++i) {
    const Squeeze& s = book_.page(static_cast<std::size_t>(i)).squeeze;
    if (s.cause >= 0.0 && s.step >= oldest)
      mine.insert(mine.end(), {static_cast<double>(atom->tag[i]), s.cause, s.depth, s.step});
  }
  const std::vector<double> squeezed = gather_all(world, mine);

  Status written;
  if (comm->me == 0) {
    std::vector<BreakEvent> events;
    for (auto v = told.begin(); v != told.end(); v += 10)
      events.push_back({v[0],
                        v[1],
                        static_cast<Tag>(v[2]),
                        static_cast<Tag>(v[3]),
                        static_cast<Tag>(v[4]),
                        {v[5], v[6], v[7]},
                        static_cast<BreakMode>(static_cast<int>(v[8])),
                        v[9]});
    std::unordered_map<Tag, Squeeze> squeezes;
    for (auto v = squeezed.begin(); v != squeezed.end(); v += 4) squeezes[static_cast<Tag>(v[0])] = {v[1], v[2], v[3]};
    for (const json::Value& line : history_.break_lines(std::move(events), squeezes))
      if (broken_ && written) written = broken_->append(line);
  }
  end_if_failed(world, written);
}

void FixBond::sample() {
  const FragmentSurvey now = survey();
  Status written;
  if (comm->me == 0) {
    const json::Value line = history_.sample_line(dem_time(*lmp), static_cast<double>(update->ntimestep), now);
    if (fragments_) written = fragments_->append(line);
  }
  end_if_failed(world, written);
}

FragmentSurvey FixBond::survey() const {
  std::vector<double> particles, bonds;
  for (int i = 0; i < atom->nlocal; ++i) {
    const BondPage& page = book_.page(static_cast<std::size_t>(i));
    if (page.agglomerate == 0.0) continue;
    const double tag = atom->tag[i], *x = atom->x[i];
    particles.insert(particles.end(), {tag, page.agglomerate, x[0], x[1], x[2], atom->radius[i]});
    for (const Bond& bond : page.bonds) bonds.insert(bonds.end(), {tag, bond.partner});
  }
  FragmentSurvey all;
  const std::vector<double> told = gather_all(world, particles), pairs = gather_all(world, bonds);
  for (auto v = told.begin(); v != told.end(); v += 6)
    all.particles.push_back({static_cast<Tag>(v[0]), static_cast<Tag>(v[1]), {{v[2], v[3], v[4]}, v[5]}});
  for (auto v = pairs.begin(); v != pairs.end(); v += 2)
    all.bonds.emplace_back(static_cast<Tag>(v[0]), static_cast<Tag>(v[1]));
  const int periodic[3] = {domain->xperiodic, domain->yperiodic, domain->zperiodic};
  for (std::size_t d = 0; d < 3; ++d) all.period[d] = periodic[d] ? domain->boxhi[d] - domain->boxlo[d] : 0.0;
  return all;
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

// ---- memory that follows the particles ----

// Of a new fix LIGGGHTS would clear all particles' pages after this, also of those that just joined an agglomerate.
void FixBond::setup_pre_exchange() {
  just_created = false;
  pre_exchange();
}

void FixBond::pre_exchange() {
  rows_to_book();
  std::size_t largest = 0;
  for (int i = 0; i < atom->nlocal; ++i) largest = std::max(largest, book_.packed_size(static_cast<std::size_t>(i)));
  comm->maxexchange_fix = std::max(comm->maxexchange_fix, static_cast<int>(largest));
}

void FixBond::grow_arrays(int n) { book_.resize(static_cast<std::size_t>(n)); }
void FixBond::copy_arrays(int from, int to, int) {
  rows_to_book();
  book_.copy(static_cast<std::size_t>(from), static_cast<std::size_t>(to));
}
void FixBond::set_arrays(int particle) { book_.clear(static_cast<std::size_t>(particle)); }

int FixBond::pack_exchange(int particle, double* buffer) {
  return static_cast<int>(book_.pack(static_cast<std::size_t>(particle), buffer));
}
int FixBond::unpack_exchange(int particle, double* buffer) {
  return static_cast<int>(book_.unpack(static_cast<std::size_t>(particle), buffer));
}

// LIGGGHTS wants the length first.
int FixBond::pack_restart(int particle, double* buffer) {
  rows_to_book();
  buffer[0] = static_cast<double>(size_restart(particle));
  book_.pack(static_cast<std::size_t>(particle), buffer + 1);
  return size_restart(particle);
}

// Our values come after those of nth other fixes.
void FixBond::unpack_restart(int particle, int nth) {
  const double* values = atom->extra[particle];
  for (int k = 0; k < nth; ++k) values += static_cast<int>(values[0]);
  book_.unpack(static_cast<std::size_t>(particle), values + 1);
}

int FixBond::size_restart(int particle) {
  return 1 + static_cast<int>(book_.packed_size(static_cast<std::size_t>(particle)));
}

int FixBond::maxsize_restart() {
  int largest = 1 + static_cast<int>(BondBook::packed_size_of(0));
  for (int i = 0; i < atom->nlocal; ++i) largest = std::max(largest, size_restart(i));
  return largest;
}

void FixBond::write_restart(FILE* file) {
  double sums[2] = {broken_here_, released_here_};
  MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, world);
  if (comm->me != 0) return;
  std::vector<double> state{grouped_ ? 1.0 : 0.0, sums[0], sums[1]};
  const std::vector<double> history = history_.state();
  state.insert(state.end(), history.begin(), history.end());
  const int size = static_cast<int>(state.size() * sizeof(double));
  fwrite(&size, sizeof size, 1, file);
  fwrite(state.data(), sizeof(double), state.size(), file);
}

void FixBond::restart(char* state) {
  const auto* values = reinterpret_cast<const double*>(state);
  grouped_ = values[0] > 0.0;
  if (comm->me != 0) return;  // rank 0 goes on with the sums of all
  broken_here_ = values[1];
  released_here_ = values[2];
  history_.set_state(values + 3);
}

// ---- between ranks ----

int FixBond::pack_comm(int n, int* list, double* buffer, int, int*) {
  for (int k = 0; k < n; ++k) {
    *buffer++ = agglomerate_[static_cast<std::size_t>(list[k])];
    *buffer++ = waiting_[static_cast<std::size_t>(list[k])];
  }
  return 2;
}

void FixBond::unpack_comm(int n, int first, double* buffer) {
  for (int k = first; k < first + n; ++k) {
    agglomerate_[static_cast<std::size_t>(k)] = *buffer++;
    waiting_[static_cast<std::size_t>(k)] = *buffer++;
  }
}

int FixBond::pack_reverse_comm(int n, int first, double* buffer) {
  std::copy_n(&numbers_[static_cast<std::size_t>(first) * n_numbers_], static_cast<std::size_t>(n) * n_numbers_,
              buffer);
  return static_cast<int>(n_numbers_);
}

void FixBond::unpack_reverse_comm(int n, int* list, double* buffer) {
  for (int k = 0; k < n; ++k)
    for (std::size_t m = 0; m < n_numbers_; ++m)
      numbers_[static_cast<std::size_t>(list[k]) * n_numbers_ + m] += *buffer++;
}

}  // namespace granary::dem
