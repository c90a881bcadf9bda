#include "pbm_solver/time/simulation.hpp"

#include <algorithm>

namespace granary::pbm {
namespace {

// Of the time between outputs: the first step, and the step below which a run is given up.
constexpr double kFirstStep = 1e-2;
constexpr double kShortestStep = 1e-10;
constexpr double kRoundOff = 1e-10;

}  // namespace

Simulation::Simulation(const PbmCase& c, const Snapshot& start, Exchange& exchange, int threads)
    : tables_(std::make_unique<ModelTables>(c)),
      exchange_(&exchange),
      row_(*tables_, exchange, threads),
      integrator_(row_, exchange, c, start.last_error, threads),
      state_(row_.size()),
      time_(start.time),
      next_step_(start.next_step > 0.0 ? start.next_step : kFirstStep * c.output_every) {
  const auto first = static_cast<std::size_t>(exchange.share().first);
  std::vector<double> one(values_per_compartment());
  for (std::size_t x = 0; x < row_.compartments(); ++x) {
    auto to = one.begin();
    for (const auto& [list, n] : lists_of(start))
      to = std::copy_n(list->begin() + static_cast<std::ptrdiff_t>((first + x) * n), n, to);
    row_.pack(one, x, state_);
  }
}

double Simulation::next_switch(double until) const {
  const PbmCase& c = tables_->pbm_case;
  std::vector<double> times{until};
  if (c.feed) times.insert(times.end(), {c.feed->start, c.feed->end});
  if (c.spray) times.insert(times.end(), {c.spray->start, c.spray->end});
  double next = until;
  for (const double t : times)
    if (t > time_) next = std::min(next, t);
  return next;
}

Result<bool> Simulation::advance(double until, const std::function<bool()>& go_on) {
  // A restart from here must find the same kernels as a run that goes on.
  row_.begin_step(state_, true);
  const double shortest = kShortestStep * tables_->pbm_case.output_every;
  while (time_ < until) {
    const double stop = next_switch(until);
    const double left = stop - time_;
    // The last two steps to a stop are equal, so that none is very short.
    const bool last = next_step_ >= left * (1.0 - kRoundOff);
    const double h = last ? left : std::min(next_step_, 0.5 * left);
    GRANARY_TRY(const Integrator::Step step, integrator_.step(state_, time_, inputs_at(tables_->pbm_case, time_), h,
                                                              next_step_, std::min(shortest, 0.5 * left)));
    time_ = last && step.taken == h ? stop : time_ + step.taken;
    next_step_ = step.next;
    if (!go_on()) return time_ >= until;
  }
  return true;
}

Snapshot Simulation::snapshot() {
  const std::size_t each = values_per_compartment();
  std::vector<double> mine(row_.compartments() * each);
  std::vector<double> all(static_cast<std::size_t>(tables_->pbm_case.compartments.count) * each);
  for (std::size_t x = 0; x < row_.compartments(); ++x) row_.unpack(state_, x, std::span(mine).subspan(x * each, each));
  exchange_->gather(mine, all);
  Snapshot s{time_, next_step_, integrator_.last_error(), {}, {}, {}, {}};
  for (auto from = all.begin(); from != all.end();)
    for (const auto& [list, n] : lists_of(s)) {
      list->insert(list->end(), from, from + static_cast<std::ptrdiff_t>(n));
      from += static_cast<std::ptrdiff_t>(n);
    }
  return s;
}

}  // namespace granary::pbm
