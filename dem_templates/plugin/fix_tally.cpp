#include "dem_templates/plugin/fix_tally.hpp"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <set>

#include <atom.h>
#include <comm.h>
#include <domain.h>
#include <force.h>
#include <modify.h>
#include <pair_gran.h>
#include <update.h>

#include "dem_templates/plugin/contacts.hpp"
#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_guard.hpp"
#include "dem_templates/plugin/fix_words.hpp"
#include "dem_templates/plugin/input/fix_arguments.hpp"

namespace granary::dem {
namespace {

using Range = FixArguments::Range;

double square(const double* v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

}  // namespace

FixTally::FixTally(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : Fix(lammps, narg, arg) {
  FixArguments arguments(fix_words(narg, arg), {{"file"}, {"every"}, {"window"}, {"axis"},
                                                {"compartments", FixArguments::kEdges}, {"classes", FixArguments::kEdges},
                                                {"body", 3, true}, {"speed_bins", 3}, {"coarse_graining"}, {"seed"}});
  file_ = arguments.text("file");
  every_ = arguments.integer_or("every", 5, Range::at_least(1));
  window_steps_ = arguments.integer("window", Range::at_least(1));
  if (every_ > 0 && window_steps_ % every_ != 0) arguments.problem("'window' must be a multiple of 'every'.");
  header_.coarse_graining = arguments.number_or("coarse_graining", 1.0, Range::positive());
  header_.seed = arguments.integer_or("seed", 0, Range::not_negative());
  header_.ranks = comm->nprocs;

  layout_.axis = arguments.axis("axis");
  layout_.compartment_edges = arguments.edges("compartments");
  layout_.class_edges = arguments.edges("classes");
  layout_.speed_edges = log_spaced(1e-3, 100.0, 64);
  if (arguments.has("speed_bins")) {
    const std::vector<double> bins = arguments.numbers("speed_bins", Range::positive());
    if (bins.size() == 3 && bins[0] >= 1.0 && bins[0] <= 1e5 && bins[0] == std::floor(bins[0]) && bins[1] < bins[2])
      layout_.speed_edges = log_spaced(bins[1], bins[2], static_cast<std::size_t>(bins[0]));
    else
      arguments.problem("'speed_bins' needs a whole number of bins, then the lowest and a larger highest speed.");
  }
  std::set<std::string> names;
  for (const auto& body : arguments.all("body")) {
    if (body[1] != "mesh" && body[1] != "wall") arguments.problem("'body " + body[0] + "' is a 'mesh' or a 'wall', not '" + body[1] + "'.");
    if (!names.insert(body[0]).second) arguments.problem("two bodies are named '" + body[0] + "'.");
    layout_.bodies.push_back(body[0]);
    bodies_.push_back({body[0], body[1], body[2], nullptr});
  }
  if (igroup != 0) arguments.problem("counts all particles: its group must be 'all'.");
  end_if_failed(world, arguments.status());

  window_.emplace(layout_);
  create_attribute = 1;
  grow_arrays(atom->nmax);
  atom->add_callback(0);
}

FixTally::~FixTally() { atom->delete_callback(id, 0); }

int FixTally::setmask() {
  return LAMMPS_NS::FixConst::POST_FORCE | LAMMPS_NS::FixConst::PRE_EXCHANGE | LAMMPS_NS::FixConst::POST_RUN;
}

void FixTally::init() {
  const std::string place = "fix " + std::string(id) + " (granary/tally): ";
  const auto require = [&](bool fine, const std::string& message) {
    if (!fine) end_if_failed(world, Error{place + message + " See docs/dem_styles.md."});
  };
  require(dynamic_cast<LAMMPS_NS::PairGran*>(force->pair) != nullptr, "needs a pair_style gran.");
  require(force->newton_pair == 0, "needs 'newton off'.");

  for (Body& body : bodies_) {
    auto wall = body.kind == "mesh" ? find_mesh_wall(*lmp, body.fix) : find_primitive_wall(*lmp, body.fix);
    require(wall.has_value(), wall ? "" : "body '" + body.name + "': " + wall.error().message);
    body.wall = std::move(wall).value();
    require(body.wall->fix_index < modify->my_index(this), "must come after the wall/gran fix of body '" + body.name + "'.");
  }
}

// What touches when a run starts has begun before it.
void FixTally::setup(int) {
  look(Purpose::remember);
  last_look_ = static_cast<long>(update->ntimestep);
  window_start_ = last_look_;
  window_start_time_ = dem_time(*lmp);
  balance_ = count_particles(*lmp);
  end_if_failed(world, open_file());
}

// After the forces of the step are known, before they act: positions, ghosts and velocities all belong to one instant.
void FixTally::post_force(int) {
  const auto step = static_cast<long>(update->ntimestep);
  if (step % every_ != 0) return;
  look(Purpose::count);
  last_look_ = step;
  if (step - window_start_ >= window_steps_) close_window();
}

// A run may end between two looks, in the middle of a window.
void FixTally::post_run() {
  const auto step = static_cast<long>(update->ntimestep);
  if (step > last_look_) {
    look(Purpose::count);
    last_look_ = step;
  }
  if (step > window_start_) close_window();
}

double FixTally::reach() const {
  double fastest2 = 0.0;
  for (int i = 0; i < atom->nlocal + atom->nghost; ++i) fastest2 = std::max(fastest2, square(atom->v[i]));
  return 2.0 * std::sqrt(fastest2) * static_cast<double>(every_) * update->dt;
}

void FixTally::look(Purpose purpose) {
  book_.begin_look();
  look_at_pairs(purpose);
  look_at_walls(purpose);
  look_at_particles(purpose);
  if (purpose == Purpose::count) window_->look_done();
}

// A pair belongs to the particle with the smaller tag, and so to the rank where that one lives: it counts there only.
void FixTally::look_at_pairs(Purpose purpose) {
  const double time_to_next_look = static_cast<double>(every_) * update->dt;
  for_each_near_pair(*lmp, reach(), [&](const NearPair& pair) {
    const bool touching = pair.gap < 0.0;
    if (!touching && pair.gap > 1.5 * pair.approach * time_to_next_look) return;
    if (touching) largest_overlap_ = std::max(largest_overlap_, pair.overlap(atom->radius));
    if (touching && purpose == Purpose::count) window_->overlap(pair.overlap(atom->radius));

    const bool i_owns = atom->tag[pair.i] < atom->tag[pair.j];
    const int owner = i_owns ? pair.i : pair.j, other = i_owns ? pair.j : pair.i;
    if (owner >= atom->nlocal) return;
    if (!touching) {
      book_.approaches(static_cast<std::size_t>(owner), atom->tag[other], pair.approach);
      return;
    }
    const auto touch = book_.touches(static_cast<std::size_t>(owner), atom->tag[other], std::abs(pair.approach));
    if (touch.began && purpose == Purpose::count) {
      const double midpoint = 0.5 * (atom->x[pair.i][layout_.axis] + atom->x[pair.j][layout_.axis]);
      window_->collision(2.0 * atom->radius[owner], 2.0 * atom->radius[other], midpoint, touch.speed);
    }
  });
}

// The speed is that of the last look, when the wall had not pushed yet; a particle that is new here has only the present one.
void FixTally::look_at_walls(Purpose purpose) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    bodies_[b].wall->touches([&](const WallTouch& at) {
      const auto particle = static_cast<std::size_t>(at.particle);
      largest_overlap_ = std::max(largest_overlap_, at.overlap);
      if (purpose == Purpose::count) window_->overlap(at.overlap);
      if (!book_.touches(particle, body_partner(b), 0.0).began || purpose == Purpose::remember) return;

      const auto approach = [&at](const double* v) {
        double speed = 0.0;
        for (std::size_t d = 0; d < 3; ++d) speed += (at.velocity[d] - v[d]) * at.normal[d];
        return speed;
      };
      const ContactBook::Memory& before = book_.memory(particle);
      double speed = before.known ? approach(before.velocity.data()) : -1.0;
      if (speed <= 0.0) speed = std::abs(approach(atom->v[at.particle]));
      window_->impact(b, 2.0 * atom->radius[at.particle], atom->x[at.particle][layout_.axis], speed);
    });
  }
}

void FixTally::look_at_particles(Purpose purpose) {
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* v = atom->v[i];
    const double axial = atom->x[i][layout_.axis];
    ContactBook::Memory& last = book_.memory(static_cast<std::size_t>(i));
    if (purpose == Purpose::count) {
      if (last.known) window_->moved(last.axial, axial);
      window_->particle(2.0 * atom->radius[i], axial, v[layout_.axis], square(v), atom->rmass[i]);
    }
    last = {true, {v[0], v[1], v[2]}, axial};
  }
}

void FixTally::leaves(int particle) {
  const ContactBook::Memory& last = book_.memory(static_cast<std::size_t>(particle));
  if (last.known) window_->moved(last.axial, atom->x[particle][layout_.axis]);
}

double FixTally::take_largest_overlap() { return std::exchange(largest_overlap_, 0.0); }

void FixTally::close_window() {
  MPI_Allreduce(MPI_IN_PLACE, window_->sums().data(), static_cast<int>(window_->sums().size()), MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, window_->maxima().data(), static_cast<int>(window_->maxima().size()), MPI_DOUBLE, MPI_MAX, world);
  const ParticleBalance balance = count_particles(*lmp);
  const double time = dem_time(*lmp);
  const WindowEnd end{.time = time,
                      .step = static_cast<long>(update->ntimestep),
                      .length = time - window_start_time_,
                      .inserted = balance.inserted - balance_.inserted,
                      .left = balance.left - balance_.left,
                      .lost = balance.lost_since(balance_)};
  end_if_failed(world, write_line(window_->line(end)));

  balance_ = balance;
  window_start_ = static_cast<long>(update->ntimestep);
  window_start_time_ = time;
  window_->clear();
}

Status FixTally::open_file() {
  if (comm->me != 0 || writer_) return {};
  GRANARY_TRY(json::LineWriter writer, json::LineWriter::create(file_));
  writer_.emplace(std::move(writer));
  header_.time_step = update->dt;
  header_.window = static_cast<double>(window_steps_) * update->dt;
  header_.start_step = static_cast<long>(update->ntimestep);
  return write_line(header_line(layout_, header_));
}

Status FixTally::write_line(const json::Value& line) { return writer_ ? writer_->append(line) : Status{}; }

void FixTally::pre_exchange() {
  std::size_t largest = 0;
  for (int i = 0; i < atom->nlocal; ++i) largest = std::max(largest, book_.packed_size(static_cast<std::size_t>(i)));
  comm->maxexchange_fix = std::max(comm->maxexchange_fix, static_cast<int>(largest));
}

void FixTally::grow_arrays(int n) { book_.resize(static_cast<std::size_t>(n)); }
void FixTally::copy_arrays(int from, int to, int) { book_.copy(static_cast<std::size_t>(from), static_cast<std::size_t>(to)); }
void FixTally::set_arrays(int particle) { book_.clear(static_cast<std::size_t>(particle)); }

int FixTally::pack_exchange(int particle, double* buffer) {
  return static_cast<int>(book_.pack(static_cast<std::size_t>(particle), buffer));
}

int FixTally::unpack_exchange(int particle, double* buffer) {
  return static_cast<int>(book_.unpack(static_cast<std::size_t>(particle), buffer));
}

}  // namespace granary::dem
