// The scheduler's promise to the first waiting task.
#include <algorithm>
#include <utility>

#include "pilot/schedule/scheduler.hpp"

namespace granary::pilot {

/// Promises the nodes on which the task's cores are there first, as far as anybody knows. Of the nodes that do not
/// have enough yet only those with most are asked, some for each node wanted: a bound, not the optimum.
void Scheduler::reserve_for(const Task& task) {
  const Layout& layout = ready_.layout(task.id);
  const NodeIndex& nodes = resources_.spare();
  struct Candidate {
    double at = 0.0;
    int node = 0;
  };
  std::vector<Candidate> candidates;
  const std::size_t enough = 16 + 2 * static_cast<std::size_t>(layout.nodes);
  for (int count = nodes.largest(); count >= 0 && candidates.size() < enough; --count) {
    for (int node = nodes.next(count, 0); node >= 0 && candidates.size() < enough; node = nodes.next(count, node + 1)) {
      const int size = resources_.end_core(node) - resources_.first_core(node);
      if (!resources_.is_up(node) || size < layout.small) continue;
      const bool lacks_memory = layout.memory > 0 && resources_.free_memory(node) < layout.memory * layout.large;
      const double at = resources_.free_at(node, std::min(size, layout.large), lacks_memory);
      candidates.push_back({at, node});
    }
  }
  if (static_cast<int>(candidates.size()) < layout.nodes) return;
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.at < b.at; });
  Reservation reservation{task.id, {}, now_};
  for (int k = 0; k < layout.nodes; ++k) {
    const int cores = layout.cores_on(k);
    const auto fits = [&](const Candidate& candidate) {
      return candidate.node >= 0 &&
             resources_.end_core(candidate.node) - resources_.first_core(candidate.node) >= cores;
    };
    const auto found = std::find_if(candidates.begin(), candidates.end(), fits);
    if (found == candidates.end()) return;
    reservation.parts.push_back({found->node, cores});
    reservation.start = std::max(reservation.start, found->at);
    found->node = -1;
  }
  promise(std::move(reservation), layout);
}

/// A node that is still busy is given up for one that has become free elsewhere.
void Scheduler::improve_reservation() {
  const Layout& layout = ready_.layout(reservation_->task);
  for (Reservation::Part& part : reservation_->parts) {
    if (resources_.has(part.node, part.cores, layout.memory)) continue;
    const auto other = places(Layout{1, part.cores, part.cores, 1, layout.memory}, false, resources_.spare(), false);
    // A node of the reservation itself may have more than it keeps; it cannot be promised twice.
    if (!other || resources_.reserved(other->front().node) > 0) continue;
    resources_.unreserve(part.node);
    part.node = other->front().node;
    resources_.reserve(part.node, part.cores, layout.memory * part.cores);
  }
}

/// Starts the task the reservation is for if it fits otherwise: on other nodes, or on its own in other roles.
bool Scheduler::start_elsewhere(const Task& task) {
  const Layout& layout = ready_.layout(task.id);
  const auto at_most = [this](int cores) {
    const auto c = static_cast<std::size_t>(cores);
    return resources_.spare().at_least()[c] + resources_.reserved_all().at_least()[c];
  };
  if (at_most(layout.large) < layout.n_large || at_most(layout.small) < layout.nodes) return false;
  Reservation kept = *reservation_;
  drop_reservation();
  if (const auto parts = places(task.id, resources_.spare_idle(), resources_.spare(), false)) {
    start_on(task, *parts);
    return true;
  }
  promise(std::move(kept), layout);
  return false;
}

void Scheduler::promise(Reservation reservation, const Layout& layout) {
  for (const Reservation::Part& part : reservation.parts)
    resources_.reserve(part.node, part.cores, layout.memory * part.cores);
  reservation_ = std::move(reservation);
}

bool Scheduler::reservation_is_complete() const {
  const Layout& layout = ready_.layout(reservation_->task);
  return std::all_of(reservation_->parts.begin(), reservation_->parts.end(), [&](const Reservation::Part& part) {
    return resources_.has(part.node, part.cores, layout.memory);
  });
}

void Scheduler::drop_reservation() {
  if (!reservation_) return;
  for (const Reservation::Part& part : reservation_->parts) resources_.unreserve(part.node);
  reservation_.reset();
}

}  // namespace granary::pilot
