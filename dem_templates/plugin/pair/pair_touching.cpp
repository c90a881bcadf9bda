#include "dem_templates/plugin/pair/pair_touching.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include <atom.h>
#include <contact_model_constants.h>
#include <force.h>
#include <global_properties.h>
#include <modify.h>
#include <neigh_list.h>
#include <update.h>

#include "dem_templates/plugin/cell_neighbor.hpp"
#include "dem_templates/plugin/contacts.hpp"

namespace granary::dem {
namespace {

// What LIGGGHTS' models of spring and friction would write.
constexpr int kTouches =
    LIGGGHTS::ContactModels::CONTACT_NORMAL_MODEL | LIGGGHTS::ContactModels::CONTACT_TANGENTIAL_MODEL;

/// The words of a pair_style in twos: "model hertz".
std::set<std::string> settings_of(int narg, char** arg) {
  std::set<std::string> all;
  for (int k = 0; k + 1 < narg; k += 2) all.insert(std::string(arg[k]) + " " + arg[k + 1]);
  if (narg % 2 != 0) all.insert(arg[narg - 1]);
  return all;
}

}  // namespace

void PairTouching::settings(int narg, char** arg) {
  std::set<std::string> all = settings_of(narg, arg);
  const bool rolls = all.erase("rolling_friction epsd2") == 1;
  is_in_rows_ = all == std::set<std::string>{"model hertz", "tangential history"};
  rows_ = PairRows(rolls);
  for (const char* known : {"model hertz", "model hooke", "tangential history", "rolling_friction cdt",
                            "rolling_friction epsd", "cohesion sjkr", "cohesion sjkr2"})
    all.erase(known);
  forgets_ = all.empty();
  PairGranProxy::settings(narg, arg);
}

void PairTouching::init_granular() {
  PairGranProxy::init_granular();
  if (!is_in_rows_) return;
  PropertyRegistry& registry = force->registry;  // LIGGGHTS' own models have registered them
  registry.connect("Yeff", young_, "pair_style gran");
  registry.connect("Geff", shear_, "pair_style gran");
  registry.connect("betaeff", damping_, "pair_style gran");
  registry.connect("coeffFrict", friction_, "pair_style gran");
  if (rows_.rolling()) registry.connect("coeffRollFrict", rolling_friction_, "pair_style gran");
  n_types_ = static_cast<std::size_t>(atom->ntypes) + 1;
  materials_.assign(n_types_ * n_types_, {});
  const auto n_known = std::min(n_types_, static_cast<std::size_t>(registry.max_type()) + 1);
  for (std::size_t i = 1; i < n_known; ++i)
    for (std::size_t j = 1; j < n_known; ++j)
      materials_[i * n_types_ + j] = {young_[i][j], shear_[i][j], damping_[i][j], friction_[i][j],
                                      rows_.rolling() ? rolling_friction_[i][j] : 0.0};
}

bool PairTouching::only_touching_matter() const {
  return neighbor->contactDistanceFactor <= 1.0 && !store_multicontact_data_ && atom->radvary_flag == 0 &&
         atom->sphere_flag != 0 && modify->n_fixes_style("insert/stream/predefined") == 0;
}

bool PairTouching::only_forces_matter(int energy, int virials, int add) const {
  return energy == 0 && virials == 0 && add == 0 && computeflag_ != 0 && shearupdate_ != 0 && atom->rmass != nullptr &&
         force->nktv2p == 1.0 && !store_contact_forces_ && !store_contact_forces_stress_ &&
         fix_sum_normal_force_ == nullptr && fix_rigid == nullptr && freeze_group_bit_ == 0;
}

double* PairTouching::remembered(const NearPairs::Pair& pair) const {
  return listgranhistory->firstdouble[pair.i] + static_cast<std::size_t>(listgranhistory->dnum) * pair.place;
}
int& PairTouching::flag(const NearPairs::Pair& pair) const { return listgranhistory->firstneigh[pair.i][pair.place]; }

void PairTouching::start() {
  listed_.clear();
  for_each_listed_pair(*lmp, [this](int i, int j, int place) {
    listed_.push_back(
        {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), static_cast<std::uint32_t>(place)});
  });
  near_.start(listed_, atom->nlocal > 0 ? atom->x[0] : nullptr, atom->radius, neighbor->skin);
  // Who remembers something has touched before the list was made.
  touched_at_.resize(near_.size());
  for (std::size_t number = 0; number < near_.size(); ++number)
    touched_at_[number] = listgranhistory && flag(near_.pair(number)) != 0 ? n_steps_ : 0;
}

void PairTouching::compute_force(int energy, int virials, int add) {
  if (!list) return PairGranProxy::compute_force(energy, virials, add);
  const CellNeighbor& lists = cell_neighbor(*lmp);
  if (std::exchange(started_, lists.n_built()) != lists.n_built() || atom->radvary_flag != 0) start();
  touching_ = near_.touching(atom->nlocal > 0 ? atom->x[0] : nullptr, lists.moved());
  n_local_ = atom->nlocal;
  largest_overlap_ = 0.0;
  if (computeflag_ != 0) note_begins();
  push_pairs(energy, virials, add);
  for_each_listener(
      [this](Listener& listener) { listener.largest_overlap = std::max(listener.largest_overlap, largest_overlap_); });
}

void PairTouching::push_pairs(int energy, int virials, int add) {
  if (is_in_rows_ && only_touching_matter() && only_forces_matter(energy, virials, add)) return push();
  note_overlaps();
  if (!only_touching_matter()) return PairGranProxy::compute_force(energy, virials, add);
  let_liggghts_push(energy, virials, add);
}

template <class Told>
void PairTouching::for_each_listener(Told&& told) {
  for (std::size_t n = 0; n < listeners_.size();) {
    if (const std::shared_ptr<Listener> listener = listeners_[n].lock()) {
      told(*listener);
      ++n;
    } else {
      listeners_.erase(listeners_.begin() + static_cast<std::ptrdiff_t>(n));
    }
  }
}

void PairTouching::note_begins() {
  const std::uint32_t before = n_steps_++;
  begin_.clear();
  for (const std::uint32_t number : touching_) {
    if (std::exchange(touched_at_[number], n_steps_) == before || shearupdate_ == 0) continue;
    const NearPairs::Pair& pair = near_.pair(number);
    if (forgets_ && listgranhistory) std::fill_n(remembered(pair), listgranhistory->dnum, 0.0);
    begin_.push_back(pair);
  }
  if (!begin_.empty()) for_each_listener([this](Listener& listener) { listener.begin(begin_); });
}

void PairTouching::note_overlaps() {
  for (const std::uint32_t number : touching_) {
    const auto& [i, j, place] = near_.pair(number);
    const double between = norm(vector_of(atom->x[i]) - vector_of(atom->x[j]));
    const double radius_i = atom->radius[i], radius_j = atom->radius[j];
    largest_overlap_ = std::max(largest_overlap_, (radius_i + radius_j - between) / std::min(radius_i, radius_j));
  }
}

void PairTouching::push() {
  evflag = vflag_fdotr = 0;
  double **const x = atom->x, **const v = atom->v, **const omega = atom->omega;
  const double *const radius = atom->radius, *const mass = atom->rmass;
  const int* const type = atom->type;
  const auto sphere = [&](std::uint32_t i) { return PairRows::Sphere{x[i], v[i], omega[i], radius[i], mass[i]}; };
  for (const std::uint32_t number : touching_) {
    const NearPairs::Pair& pair = near_.pair(number);
    const auto material = static_cast<std::size_t>(type[pair.i]) * n_types_ + static_cast<std::size_t>(type[pair.j]);
    flag(pair) |= kTouches;
    queued_[rows_.size()] = pair;
    rows_.add(materials_[material], sphere(pair.i), sphere(pair.j), remembered(pair));
    if (rows_.full()) push_queued();
  }
  push_queued();
}

void PairTouching::push_queued() {
  if (rows_.size() == 0) return;
  largest_overlap_ = std::max(largest_overlap_, rows_.advance(update->dt));
  const auto n_local = static_cast<std::uint32_t>(atom->nlocal);
  double *const forces = atom->f[0], *const torques = atom->torque[0];
  const auto add = [](double* to, const Vector3& v) {
    for (std::size_t d = 0; d < 3; ++d) to[d] += v[d];
  };
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const NearPairs::Pair& pair = queued_[k];
    rows_.write_history(k, remembered(pair));
    add(forces + 3 * pair.i, rows_.force(k));
    add(torques + 3 * pair.i, rows_.torque_i(k));
    if (pair.j >= n_local) continue;
    add(forces + 3 * pair.j, -1.0 * rows_.force(k));
    add(torques + 3 * pair.j, rows_.torque_j(k));
  }
  rows_.clear();
}

// The list is a shorter one only as long as LIGGGHTS works out the forces.
void PairTouching::let_liggghts_push(int energy, int virials, int add) {
  with_partner_.clear();
  for (const std::uint32_t number : touching_) with_partner_.push_back(static_cast<int>(near_.pair(number).i));
  std::sort(with_partner_.begin(), with_partner_.end());
  with_partner_.erase(std::unique(with_partner_.begin(), with_partner_.end()), with_partner_.end());
  const int all = std::exchange(list->inum, static_cast<int>(with_partner_.size()));
  int* const numbers = std::exchange(list->ilist, with_partner_.data());
  PairGranProxy::compute_force(energy, virials, add);
  list->inum = all;
  list->ilist = numbers;
}

bool PairTouching::knows_who_remembers() const {
  return forgets_ && list && listgranhistory && started_ == cell_neighbor(*lmp).n_built() && only_touching_matter();
}

}  // namespace granary::dem
