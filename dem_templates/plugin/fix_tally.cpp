#include "dem_templates/plugin/fix_tally.hpp"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <utility>

#include <atom.h>
#include <comm.h>
#include <force.h>
#include <modify.h>
#include <timer.h>
#include <update.h>

#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_guard.hpp"
#include "dem_templates/plugin/fix_words.hpp"
#include "dem_templates/plugin/input/fix_arguments.hpp"
#include "dem_templates/plugin/tally/told_lines.hpp"
#include "dem_templates/plugin/tally/touch_speed.hpp"
#include "dem_templates/plugin/wall/fix_wall.hpp"

namespace granary::dem {
namespace {

using Range = FixArguments::Range;

// Speeds and places change over collisions, some milliseconds, not over looks.
constexpr long kLooksPerSurvey = 8;

}  // namespace

FixTally::FixTally(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : Fix(lammps, narg, arg) {
  FixArguments arguments(fix_words(narg, arg), {{"file"},
                                                {"every"},
                                                {"window"},
                                                {"axis"},
                                                {"compartments", FixArguments::kEdges},
                                                {"classes", FixArguments::kEdges},
                                                {"body", 3, true},
                                                {"speed_bins", 3},
                                                {"coarse_graining"},
                                                {"seed"},
                                                {"goes_on"}});
  file_ = arguments.text("file");
  every_ = arguments.integer_or("every", 5, Range::at_least(1));
  window_steps_ = arguments.integer("window", Range::at_least(1));
  if (every_ > 0 && window_steps_ % every_ != 0) arguments.problem("'window' must be a multiple of 'every'.");
  header_.coarse_graining = arguments.number_or("coarse_graining", 1.0, Range::positive());
  goes_on_ = arguments.text_or("goes_on", "no") == "yes";
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
    if (body[1] != "mesh" && body[1] != "wall" && body[1] != "of")
      arguments.problem("'body " + body[0] + "' is 'of' a granary/wall, a 'mesh' or a 'wall', not '" + body[1] + "'.");
    if (!names.insert(body[0]).second) arguments.problem("two bodies are named '" + body[0] + "'.");
    layout_.bodies.push_back(body[0]);
    bodies_.push_back({body[0], body[1], body[2]});
  }
  if (bodies_.size() > kMostBodies)
    arguments.problem("counts impacts on at most " + std::to_string(kMostBodies) + " bodies.");
  if (igroup != 0) arguments.problem("counts all particles: its group must be 'all'.");
  end_if_failed(world, arguments.status());

  window_.emplace(layout_);
  create_attribute = 1;
  grow_arrays(atom->nmax);
  atom->add_callback(0);
}

FixTally::~FixTally() {
  atom->delete_callback(id, 0);
  // The walls may be gone before.
  for (int f = 0; f < modify->nfix; ++f)
    for (const Body& body : bodies_)
      if (body.walls && modify->fix[f] == body.walls) body.walls->set_listener({});
}

int FixTally::setmask() { return LAMMPS_NS::FixConst::POST_FORCE | LAMMPS_NS::FixConst::POST_RUN; }

void FixTally::init() {
  const std::string place = "fix " + std::string(id) + " (granary/tally): ";
  const auto require = [&](bool fine, const std::string& message) {
    if (!fine) end_if_failed(world, Error{place + message + " See docs/dem_styles.md."});
  };
  pairs_ = dynamic_cast<PairTouching*>(force->pair);
  require(pairs_ != nullptr, "needs a pair_style gran.");
  require(force->newton_pair == 0, "needs 'newton off'.");

  for (Body& body : bodies_) {
    const Status found = find(body);
    require(found.has_value(), found ? "" : "body '" + body.name + "': " + found.error().message);
    const int index = body.walls ? modify->my_index(body.walls) : body.wall->fix_index;
    require(index < modify->my_index(this), "must come after the wall fix of body '" + body.name + "'.");
  }
  listen();
}

Status FixTally::find(Body& body) {
  if (body.kind != "of") {
    GRANARY_TRY(body.wall, body.kind == "mesh" ? find_mesh_wall(*lmp, body.fix) : find_primitive_wall(*lmp, body.fix));
    return {};
  }
  body.walls = dynamic_cast<FixWall*>(modify->find_fix_id(body.fix.c_str()));
  if (!body.walls) return Error{"there is no granary/wall fix '" + body.fix + "'."};
  const auto names = body.walls->body_names();
  const auto name = std::find(names.begin(), names.end(), body.name);
  if (name == names.end()) return Error{"the granary/wall fix '" + body.fix + "' has no body of that name."};
  body.place = static_cast<std::size_t>(name - names.begin());
  for (int f = 0; f < modify->nfix; ++f)
    if (const auto* other = dynamic_cast<FixTally*>(modify->fix[f]); other && other != this)
      for (const Body& theirs : other->bodies_)
        if (theirs.walls == body.walls)
          return Error{"fix '" + std::string(other->id) + "' already counts the impacts on '" + body.fix + "'."};
  return {};
}

// The pair forces and our walls see every step: each contact is known as it begins.
void FixTally::listen() {
  listener_ = std::make_shared<PairTouching::Listener>();
  listener_->begin = [this](std::span<const NearPairs::Pair> began) { count_collisions(began); };
  pairs_->add_listener(listener_);
  for (const Body& body : bodies_) {
    if (!body.walls) continue;
    std::vector<std::size_t> number(body.walls->body_names().size(), bodies_.size());
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (bodies_[b].walls == body.walls) number[bodies_[b].place] = b;
    body.walls->set_listener([this, number](std::size_t place, int particle, double speed) {
      if (number[place] == bodies_.size()) return;
      window_->impact(number[place], 2.0 * atom->radius[particle], atom->x[particle][layout_.axis], speed);
    });
  }
}

// What touches when a run starts has begun before it.
void FixTally::setup(int) {
  if (!pairs_->listgranhistory)
    end_if_failed(world,
                  Error{"fix " + std::string(id) +
                        " (granary/tally): needs a pair_style gran with 'tangential history', which tells from one "
                        "neighbour list to the next which pairs touch. See docs/dem_styles.md."});
  own_seconds_ = 0.0;
  listener_->largest_overlap = 0.0;
  look_at_walls(Purpose::remember);
  survey(Purpose::remember);
  last_look_ = static_cast<long>(update->ntimestep);
  looks_ = 0;
  window_start_ = last_look_;
  window_start_time_ = dem_time(*lmp);
  balance_ = count_particles(*lmp);
  end_if_failed(world, open_file());
}

// After the forces of the step are known, before they act: positions, ghosts and velocities all belong to one instant.
void FixTally::post_force(int) {
  const auto step = static_cast<long>(update->ntimestep);
  if (step % every_ != 0) return;
  const double start = MPI_Wtime();
  look(step);
  const bool window_ends = step - window_start_ >= window_steps_;
  if (++looks_ % kLooksPerSurvey == 0 || window_ends) survey(Purpose::count);
  if (window_ends) close_window();
  own_seconds_ += MPI_Wtime() - start;
}

// A run may end between two looks, in the middle of a window.
void FixTally::post_run() {
  say_cost();
  const auto step = static_cast<long>(update->ntimestep);
  if (step == window_start_) return;
  if (step > last_look_) look(step);
  survey(Purpose::count);
  close_window();
}

void FixTally::say_cost() const {
  const double pairs = timer->array[TIME_PAIR];
  if (comm->me != 0 || pairs <= 0.0) return;
  for (FILE* out : {screen, logfile})
    if (out)
      std::fprintf(out, "granary/tally: %.4g s, %.2f %% of the %.4g s of the pair forces\n", own_seconds_,
                   100.0 * own_seconds_ / pairs, pairs);
}

void FixTally::look(long step) {
  window_->overlap(std::exchange(listener_->largest_overlap, 0.0));
  look_at_walls(Purpose::count);
  look_at_loads();
  last_look_ = step;
}

// A pair belongs to the particle with the smaller tag, and so to the rank where that one lives: it counts there.
void FixTally::count_collisions(std::span<const NearPairs::Pair> began) {
  const double start = MPI_Wtime();
  const auto n_local = static_cast<std::uint32_t>(atom->nlocal);
  for (const auto& [i, j, place] : began) {
    if ((atom->tag[i] < atom->tag[j] ? i : j) >= n_local) continue;
    const Vector3 between = vector_of(atom->x[i]) - vector_of(atom->x[j]);
    const Vector3 velocity = vector_of(atom->v[i]) - vector_of(atom->v[j]);
    const double radius_i = atom->radius[i], radius_j = atom->radius[j];
    const double axial = 0.5 * (atom->x[i][layout_.axis] + atom->x[j][layout_.axis]);
    window_->collision(2.0 * radius_i, 2.0 * radius_j, axial,
                       touch_speed(between.data(), velocity.data(), radius_i + radius_j));
  }
  own_seconds_ += MPI_Wtime() - start;
}

void FixTally::look_at_walls(Purpose purpose) {
  if (std::none_of(bodies_.begin(), bodies_.end(), [](const Body& body) { return body.wall != nullptr; })) return;
  bodies_touched_.assign(static_cast<std::size_t>(atom->nlocal), 0);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!bodies_[b].wall) continue;
    bodies_[b].wall->touches([&](const WallTouch& touch) {
      const auto particle = static_cast<std::size_t>(touch.particle);
      const std::uint64_t bit = std::uint64_t{1} << b;
      bodies_touched_[particle] |= bit;
      if (purpose == Purpose::remember) return;
      window_->overlap(touch.overlap);
      if (!(memories_[particle].bodies & bit)) count_impact(b, touch);
    });
  }
  for (int i = 0; i < atom->nlocal; ++i) {
    Memory& last = memories_[static_cast<std::size_t>(i)];
    last.known = true;
    std::copy_n(atom->v[i], 3, last.velocity.begin());
    last.bodies = bodies_touched_[static_cast<std::size_t>(i)];
  }
}

void FixTally::look_at_loads() {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!bodies_[b].walls) continue;
    const FixWall::Load load = bodies_[b].walls->load(bodies_[b].place);
    window_->load(b, {load.force, load.torque, load.axial_torque, load.power});
    window_->overlap(bodies_[b].walls->take_largest_overlap());
  }
  window_->loads_done();
}

// The speed is that of the last look, when the wall had not pushed yet; a particle that is new here has only the
// present one.
void FixTally::count_impact(std::size_t body, const WallTouch& touch) {
  const auto approach = [&touch](const double* v) {
    double speed = 0.0;
    for (std::size_t d = 0; d < 3; ++d) speed += (touch.velocity[d] - v[d]) * touch.normal[d];
    return speed;
  };
  const Memory& last = memories_[static_cast<std::size_t>(touch.particle)];
  double speed = last.known ? approach(last.velocity.data()) : -1.0;
  if (speed <= 0.0) speed = std::abs(approach(atom->v[touch.particle]));
  window_->impact(body, 2.0 * atom->radius[touch.particle], atom->x[touch.particle][layout_.axis], speed);
}

void FixTally::survey(Purpose purpose) {
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* v = atom->v[i];
    const double axial = atom->x[i][layout_.axis];
    Memory& last = memories_[static_cast<std::size_t>(i)];
    if (purpose == Purpose::count) {
      if (!std::isnan(last.axial)) window_->moved(last.axial, axial);
      window_->particle(2.0 * atom->radius[i], axial, v[layout_.axis], dot3(v, v), atom->rmass[i]);
    }
    last.axial = axial;
  }
  if (purpose == Purpose::remember) return;
  window_->survey_done();
}

void FixTally::leaves(int particle) {
  const Memory& last = memories_[static_cast<std::size_t>(particle)];
  if (!std::isnan(last.axial)) window_->moved(last.axial, atom->x[particle][layout_.axis]);
}

void FixTally::close_window() {
  MPI_Allreduce(MPI_IN_PLACE, window_->sums().data(), static_cast<int>(window_->sums().size()), MPI_DOUBLE, MPI_SUM,
                world);
  MPI_Allreduce(MPI_IN_PLACE, window_->maxima().data(), static_cast<int>(window_->maxima().size()), MPI_DOUBLE, MPI_MAX,
                world);
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
  looks_ = 0;
}

Status FixTally::open_file() {
  if (comm->me != 0 || writer_) return {};
  if (goes_on_ && std::filesystem::exists(file_)) {
    GRANARY_TRY(writer_, go_on_telling(file_, dem_time(*lmp)));
    return {};
  }
  GRANARY_TRY(json::LineWriter writer, json::LineWriter::create(file_));
  writer_.emplace(std::move(writer));
  header_.time_step = update->dt;
  header_.window = static_cast<double>(window_steps_) * update->dt;
  header_.start_step = static_cast<long>(update->ntimestep);
  return write_line(header_line(layout_, header_));
}

Status FixTally::write_line(const json::Value& line) { return writer_ ? writer_->append(line) : Status{}; }

void FixTally::grow_arrays(int n) { memories_.resize(static_cast<std::size_t>(n)); }
void FixTally::copy_arrays(int from, int to, int) {
  memories_[static_cast<std::size_t>(to)] = memories_[static_cast<std::size_t>(from)];
}
void FixTally::set_arrays(int particle) { memories_[static_cast<std::size_t>(particle)] = {}; }

int FixTally::pack_exchange(int particle, double* buffer) {
  memories_[static_cast<std::size_t>(particle)].pack(buffer);
  return static_cast<int>(Memory::kDoubles);
}
int FixTally::unpack_exchange(int particle, double* buffer) {
  memories_[static_cast<std::size_t>(particle)] = Memory::unpack(buffer);
  return static_cast<int>(Memory::kDoubles);
}

}  // namespace granary::dem
