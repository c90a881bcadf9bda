// Which pairs of particles touch, and which began to: the part of granary/tally that reads the pair style's flags.
#include <algorithm>
#include <cmath>
#include <utility>

#include <atom.h>
#include <neighbor.h>
#include <update.h>

#include "dem_templates/plugin/contacts.hpp"
#include "dem_templates/plugin/fix_tally.hpp"
#include "dem_templates/plugin/tally/touch_speed.hpp"

namespace granary::dem {

// The pair forces look at every pair in every step and flag those that touch, until the next neighbour list. So all
// that is left to do is to go over the flagged ones, a few hundred in a stirred mixer.
void FixTally::look_at_pairs(Purpose purpose, double ago) {
  const bool fresh = std::exchange(list_is_new_, false);
  known_.swap(contacts_);
  contacts_.clear();
  std::size_t next = 0;
  double largest_overlap = 0.0;
  for_each_pair_that_touched(*lmp, [&](int i, int j, std::uint64_t slot) {
    while (next < known_.size() && known_[next].slot < slot) ++next;
    const bool known = next < known_.size() && known_[next].slot == slot;
    if (ago > 0.0 && j >= n_local_ && atom->nlocal != n_local_) return;  // new particles lie where ghosts were

    const Approach now = approach(i, j, ago);
    const auto [owner, other] = std::minmax(atom->tag[i], atom->tag[j]);
    // A pair belongs to the particle with the smaller tag, and so to the rank where that one lives: it counts there.
    const bool counts_here = (owner == atom->tag[i] ? i : j) < atom->nlocal;
    contacts_.push_back({slot, counts_here && now.touches(), owner, other});
    if (now.touches())
      largest_overlap = std::max(largest_overlap,
                                 (now.reach - std::sqrt(now.distance2)) / std::min(atom->radius[i], atom->radius[j]));
    if (purpose == Purpose::remember || !counts_here) return;
    if (known ? known_[next].touching : fresh && book_.touched(owner, other)) return;
    if (now.touches())
      count_collision(now);
    else if (known)
      count_graze(now);
    else if (neighbor->contactDistanceFactor <= 1.0)  // else who comes near is flagged too
      count_parted(now);
  });
  if (purpose == Purpose::count) window_->overlap(largest_overlap);
}

FixTally::Approach FixTally::approach(int i, int j, double ago) const {
  const double *xi = atom->x[i], *xj = atom->x[j], *vi = atom->v[i], *vj = atom->v[j];
  const double j_moved = j < atom->nlocal ? ago : 0.0;  // a ghost stands where it was
  Approach now{.i = i, .j = j, .reach = atom->radius[i] + atom->radius[j]};
  for (int k = 0; k < 3; ++k) {
    now.v[k] = vi[k] - vj[k];
    now.d[k] = (xi[k] - ago * vi[k]) - (xj[k] - j_moved * vj[k]);
  }
  now.distance2 = dot3(now.d, now.d);
  return now;
}

const double* FixTally::velocity_before(int k) {
  if (k < atom->nlocal) {
    const ContactBook::Memory& last = book_.memory(static_cast<std::size_t>(k));
    return last.known ? last.velocity.data() : nullptr;
  }
  return ghost_velocity_.empty() ? nullptr : ghost_velocity_[static_cast<std::size_t>(k - atom->nlocal)].data();
}

void FixTally::count_collision(const Approach& now, double speed) {
  const double axial = 0.5 * (atom->x[now.i][layout_.axis] + atom->x[now.j][layout_.axis]);
  window_->collision(2.0 * atom->radius[now.i], 2.0 * atom->radius[now.j], axial, speed);
}

// Its speed is that before the contact pushed: at the last look. A ghost that is new here has only its present one.
void FixTally::count_collision(const Approach& now) {
  double before[3];
  relative_velocity_before(now, before);
  count_collision(now, touch_speed(now.d, before, now.reach));
}

// It was flagged since the last look and is apart again.
void FixTally::count_parted(const Approach& now) {
  double before[3];
  relative_velocity_before(now, before);
  count_collision(now, parted_speed(now.d, before, now.v, now.reach));
}

void FixTally::relative_velocity_before(const Approach& now, double* v) {
  const double *vi = velocity_before(now.i), *vj = velocity_before(now.j);
  for (int k = 0; k < 3; ++k) v[k] = vi && vj ? vi[k] - vj[k] : now.v[k];
}

// It was flagged before: only its way tells whether it touched again. The velocities are those of the last
// displacement; before it the two flew nearly as fast, since a touch that lasts less than a few steps hardly turns
// them. So the steps since the last look are gone back on a straight line.
void FixTally::count_graze(const Approach& now) {
  const auto steps = static_cast<double>(static_cast<long>(update->ntimestep) - last_look_);
  const double apart = dot3(now.d, now.v), v2 = dot3(now.v, now.v);
  const double reach2 = now.reach * now.reach;
  if (apart <= 0.0 || now.distance2 - apart * apart / v2 >= reach2) return;  // was never nearer, or not near enough

  const double nearest = apart / v2 / update->dt;  // steps ago
  for (const double back : {std::floor(nearest), std::ceil(nearest)}) {
    if (back < 1.0 || back >= steps) continue;
    double then[3];
    for (int k = 0; k < 3; ++k) then[k] = now.d[k] - back * update->dt * now.v[k];
    if (dot3(then, then) >= reach2) continue;
    count_collision(now, touch_speed(then, now.v, now.reach));
    return;
  }
}

// The last moment at which the old list's numbers are those of the particles. They have moved on by a step since the
// forces, whose flags may tell of contacts that no look has seen.
void FixTally::contacts_to_book() {
  const auto step = static_cast<long>(update->ntimestep);
  if (step == booked_) return;
  booked_ = step;
  if (step - 1 > last_look_) look_at_pairs(Purpose::count, update->dt);
  list_is_new_ = true;
  ghost_velocity_.clear();
  book_.forget_pairs();
  for (const Contact& contact : contacts_)
    if (contact.touching) book_.note_pair(contact.owner, contact.other);
  contacts_.clear();
}

}  // namespace granary::dem
