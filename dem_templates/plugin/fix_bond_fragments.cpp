// What granary/bond tells: breaks with their causes, and fragments.
#include <mpi.h>

#include <algorithm>
#include <cmath>

#include <atom.h>
#include <comm.h>
#include <domain.h>
#include <modify.h>
#include <update.h>

#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_bond.hpp"
#include "dem_templates/plugin/fix_guard.hpp"
#include "dem_templates/plugin/gather.hpp"
#include "dem_templates/plugin/tally/told_lines.hpp"
#include "dem_templates/plugin/wall/fix_wall.hpp"

namespace granary::dem {

// The walls hand over each touch of each step as they push.
void FixBond::hear_walls() {
  std::vector<std::string> names{"particles"};
  heard_.clear();
  for (int f = 0; f < modify->nfix; ++f) {
    auto* wall = dynamic_cast<FixWall*>(modify->fix[f]);
    if (!wall) continue;
    const std::size_t first = names.size();
    for (const std::string& name : wall->body_names()) names.push_back(name);
    heard_.push_back(wall);
    wall->set_touch_listener([this, first](std::size_t body, int particle, double depth) {
      book_.page(static_cast<std::size_t>(particle))
          .squeeze.note(static_cast<double>(update->ntimestep), static_cast<double>(first + body), depth,
                        window_steps());
    });
  }
  history_.set_causes(names, window_steps());
}

// The walls may be gone before.
void FixBond::leave_walls() {
  for (int f = 0; f < modify->nfix; ++f)
    for (FixWall* wall : heard_)
      if (modify->fix[f] == wall) wall->set_touch_listener({});
}

double FixBond::window_steps() const { return settings_.cause_window / update->dt; }

void FixBond::start_telling() {
  const FragmentSurvey now = survey();
  if (comm->me == 0) {
    const auto open = [&](const std::string& file, std::optional<json::LineWriter>& writer) -> Status {
      if (file.empty() || writer) return {};
      GRANARY_TRY(writer, go_on_telling(file, dem_time(*lmp)));
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

// Every rank has all bonds at hand and finds the same.
void FixBond::number_fragments() {
  fragments_old_ = false;
  fragment_of_tag_ = fragment_labels(all_bonds());
}

Tag FixBond::fragment_of(int particle) const {
  const Tag tag = atom->tag[particle];
  return static_cast<std::size_t>(tag) < fragment_of_tag_.size() ? fragment_of_tag_[static_cast<std::size_t>(tag)]
                                                                 : tag;
}

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
  std::vector<double> mine;
  for (int i = 0; i < atom->nlocal; ++i) {
    const double agglomerate = book_.page(static_cast<std::size_t>(i)).agglomerate, *x = atom->x[i];
    if (agglomerate > 0.0)
      mine.insert(mine.end(), {static_cast<double>(atom->tag[i]), agglomerate, x[0], x[1], x[2], atom->radius[i]});
  }
  FragmentSurvey all{.particles = {}, .bonds = all_bonds()};
  const std::vector<double> told = gather_all(world, mine);
  for (auto v = told.begin(); v != told.end(); v += 6)
    all.particles.push_back({static_cast<Tag>(v[0]), static_cast<Tag>(v[1]), {{v[2], v[3], v[4]}, v[5]}});
  const int periodic[3] = {domain->xperiodic, domain->yperiodic, domain->zperiodic};
  for (std::size_t d = 0; d < 3; ++d) all.period[d] = periodic[d] ? domain->boxhi[d] - domain->boxlo[d] : 0.0;
  return all;
}

std::vector<std::pair<Tag, Tag>> FixBond::all_bonds() const {
  std::vector<double> mine;
  for (int i = 0; i < atom->nlocal; ++i)
    for (const Bond& bond : book_.page(static_cast<std::size_t>(i)).bonds)
      if (!bond.broken()) mine.insert(mine.end(), {static_cast<double>(atom->tag[i]), bond.partner});
  const std::vector<double> told = gather_all(world, mine);
  std::vector<std::pair<Tag, Tag>> bonds;
  for (auto v = told.begin(); v != told.end(); v += 2)
    bonds.emplace_back(static_cast<Tag>(v[0]), static_cast<Tag>(v[1]));
  return bonds;
}

}  // namespace granary::dem
