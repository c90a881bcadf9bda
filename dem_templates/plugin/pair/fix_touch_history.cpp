#include "dem_templates/plugin/pair/fix_touch_history.hpp"

#include <algorithm>

#include <atom.h>
#include <comm.h>
#include <error.h>

#include "dem_templates/plugin/pair/pair_touching.hpp"

namespace granary::dem {

// Each of the two gets the other's tag and what it remembers, as it sees it. Of a ghost its own rank does.
void FixTouchHistory::pre_exchange() {
  const auto* pairs = dynamic_cast<const PairTouching*>(pair_gran_);
  if (!pairs || !pairs->knows_who_remembers()) return FixContactHistory::pre_exchange();
  const int n_local = pairs->n_local();
  std::fill_n(npartner_, std::max(n_local, atom->nlocal), 0);
  pairs->for_each_that_remembers([&](int i, int j, const double*) {
    ++npartner_[i];
    if (j < n_local) ++npartner_[j];
  });

  ipage_->reset();
  dpage_->reset();
  n_noted_.assign(static_cast<std::size_t>(n_local), 0);
  const auto note = [&](int i, int partner, const double* values, bool as_the_other_sees_it) {
    int& n = n_noted_[static_cast<std::size_t>(i)];
    if (n == 0) {
      partner_[i] = ipage_->get(npartner_[i]);
      contacthistory_[i] = dpage_->get(npartner_[i] * dnum_);
      if (!partner_[i] || !contacthistory_[i]) error->one(FLERR, "Contact history overflow, boost neigh_modify one");
    }
    partner_[i][n] = partner;
    for (int d = 0; d < dnum_; ++d)
      contacthistory_[i][n * dnum_ + d] = as_the_other_sees_it && newtonflag_[d] != 0 ? -values[d] : values[d];
    ++n;
  };
  pairs->for_each_that_remembers([&](int i, int j, const double* values) {
    note(i, atom->tag[j], values, false);
    if (j < n_local) note(j, atom->tag[i], values, true);
  });

  maxtouch_ = n_noted_.empty() ? 0 : *std::max_element(n_noted_.begin(), n_noted_.end());
  comm->maxexchange_fix = std::max(comm->maxexchange_fix, (dnum_ + 1) * maxtouch_ + 1);
}

}  // namespace granary::dem
