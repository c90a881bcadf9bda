#include "dem_templates/plugin/wall/fix_wall.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include <atom.h>
#include <comm.h>
#include <error.h>
#include <force.h>
#include <global_properties.h>
#include <memory.h>
#include <modify.h>
#include <update.h>

#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_words.hpp"
#include "dem_templates/plugin/wall/stl_triangles.hpp"

namespace granary::dem {
namespace {

using Range = FixArguments::Range;

Vector3 vector_of(const double* v) { return {v[0], v[1], v[2]}; }
void add(double* to, const Vector3& v) {
  for (std::size_t d = 0; d < 3; ++d) to[d] += v[d];
}

// Words first to last of a keyword, as numbers.
std::vector<double> numbers_of(FixArguments& arguments, const std::string& keyword,
                               const std::vector<std::string>& words, std::size_t first, std::size_t last) {
  std::vector<double> values;
  for (std::size_t w = first; w < last; ++w) {
    double value = 0.0;
    const char* end = words[w].data() + words[w].size();
    const auto [stop, fault] = std::from_chars(words[w].data(), end, value);
    if (fault != std::errc{} || stop != end || !std::isfinite(value))
      arguments.problem("'" + keyword + " " + words[0] + "': '" + words[w] + "' is no number.");
    values.push_back(value);
  }
  return values;
}

Vector3 direction_of(FixArguments& arguments, const std::string& what, const double* v) {
  const Vector3 direction = vector_of(v);
  if (norm(direction) > 0.0) return (1.0 / norm(direction)) * direction;
  arguments.problem("'" + what + "': the direction must not be 0 0 0.");
  return {0, 0, 1};
}

}  // namespace

FixWall::FixWall(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : Fix(lammps, narg, arg) {
  FixArguments arguments(fix_words(narg, arg), {{"type"},
                                                {"rolling_friction"},
                                                {"cohesion"},
                                                {"smooth"},
                                                {"mesh", 2, true},
                                                {"plane", 7, true},
                                                {"cylinder", 8, true},
                                                {"rotate", 9, true}});
  read(arguments);
  end_if_failed(world, arguments.status());

  vector_flag = 1;
  size_vector = static_cast<int>(bodies_.size() * kSums);
  global_freq = 1;
  extvector = 0;
  create_attribute = 1;
  restart_global = 1;
  restart_peratom = 1;
  grow_arrays(atom->nmax);
  atom->add_callback(0);
  atom->add_callback(1);
}

FixWall::~FixWall() {
  atom->delete_callback(id, 0);
  atom->delete_callback(id, 1);
}

void FixWall::read(FixArguments& arguments) {
  type_ = static_cast<int>(arguments.integer("type", Range::at_least(1)));
  const std::string rolling = arguments.text_or("rolling_friction", "off");
  if (rolling == "epsd2")
    rolling_ = RollingModel::epsd2;
  else if (rolling == "cdt")
    rolling_ = RollingModel::cdt;
  else if (rolling != "off")
    arguments.problem("'rolling_friction' is '" + rolling + "'; it must be off, cdt or epsd2.");
  const std::string cohesion = arguments.text_or("cohesion", "off");
  cohesion_ = cohesion == "sjkr";
  if (!cohesion_ && cohesion != "off") arguments.problem("'cohesion' is '" + cohesion + "'; it must be off or sjkr.");
  const double smooth = arguments.number_or("smooth", 5.0, Range::not_negative()) * M_PI / 180.0;
  if (smooth > 0.5 * M_PI) arguments.problem("'smooth' must be at most 90 degrees.");

  for (const auto& words : arguments.all("mesh")) {
    auto triangles = read_stl_triangles(words[1]);
    if (!triangles)
      arguments.problem("'mesh " + words[0] + "': " + triangles.error().message);
    else
      add_body(arguments, words[0], std::make_unique<MeshSurface>(std::move(triangles).value(), smooth));
  }
  for (const auto& words : arguments.all("plane")) {
    const auto v = numbers_of(arguments, "plane", words, 1, 7);
    add_body(arguments, words[0],
             std::make_unique<PlaneSurface>(vector_of(&v[0]), direction_of(arguments, "plane " + words[0], &v[3])));
  }
  for (const auto& words : arguments.all("cylinder")) {
    const auto v = numbers_of(arguments, "cylinder", words, 1, 8);
    if (v[6] <= 0.0) arguments.problem("'cylinder " + words[0] + "': the radius must be above 0.");
    add_body(arguments, words[0],
             std::make_unique<CylinderSurface>(vector_of(&v[0]), direction_of(arguments, "cylinder " + words[0], &v[3]),
                                               v[6]));
  }
  if (bodies_.empty()) arguments.problem("needs a body: 'mesh', 'plane' or 'cylinder'.");

  for (const auto& words : arguments.all("rotate")) {
    const auto body = std::find_if(bodies_.begin(), bodies_.end(), [&](const Body& b) { return b.name == words[0]; });
    if (body == bodies_.end()) {
      arguments.problem("'rotate " + words[0] + "': there is no body of that name.");
      continue;
    }
    const auto v = numbers_of(arguments, "rotate", words, 1, 7);
    const double value = numbers_of(arguments, "rotate", words, 8, 9)[0];
    body->rotation.origin = vector_of(&v[0]);
    body->rotation.axis = direction_of(arguments, "rotate " + words[0], &v[3]);
    if (words[7] == "rpm")
      body->rotation.rate = value * 2.0 * M_PI / 60.0;
    else if (words[7] == "rad/s")
      body->rotation.rate = value;
    else if (words[7] == "period" && value != 0.0)
      body->rotation.rate = 2.0 * M_PI / value;
    else
      arguments.problem("'rotate " + words[0] + "' ends with '" + words[7] + " " + words[8] +
                        "'; it must be 'rpm N', 'rad/s W' or 'period SECONDS' (not 0).");
  }
}

void FixWall::add_body(FixArguments& arguments, const std::string& name, std::unique_ptr<Surface> surface) {
  for (const Body& body : bodies_)
    if (body.name == name) arguments.problem("two bodies are named '" + name + "'.");
  bodies_.emplace_back();
  bodies_.back().name = name;
  bodies_.back().surface = std::move(surface);
}

int FixWall::setmask() { return LAMMPS_NS::FixConst::POST_FORCE; }

void FixWall::init() {
  const std::string place = "fix " + std::string(id) + " (granary/wall): ";
  if (!atom->sphere_flag || !atom->radius || !atom->rmass)
    end_if_failed(world, Error{place + "needs spheres: 'atom_style granular'. See docs/dem_styles.md."});
  if (type_ > atom->ntypes)
    end_if_failed(world, Error{place + "type " + std::to_string(type_) + " is above the " +
                               std::to_string(atom->ntypes) + " type(s) of the box. See docs/dem_styles.md."});
  read_materials();

  const auto step = static_cast<long>(update->ntimestep);
  for (Body& body : bodies_) {
    const double per_step = body.rotation.rate * update->dt;
    if (body.start_step >= 0 && per_step == body.angle_per_step) continue;
    body.start_angle = body.start_step < 0 ? 0.0 : body.angle(step);
    body.start_step = step;
    body.angle_per_step = per_step;
  }
  end_if_failed(world, check_steps());
}

// At half a radius a step the blade is seen at least once before it reaches a centre.
Status FixWall::check_steps() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < atom->nlocal; ++i) smallest = std::min(smallest, atom->radius[i]);
  for (const Body& body : bodies_) {
    const double way =
        std::abs(body.angle_per_step) * body.surface->farthest_from(body.rotation.origin, body.rotation.axis);
    if (way > 0.5 * smallest)
      return Error{fmt::format(
          "fix {} (granary/wall): body '{}' goes {:.3g} m a step at its tip; at most half the smallest particle's "
          "radius "
          "({:.3g} m) lets no particle slip through. Take a time step below {:.3g} s. See docs/dem_styles.md.",
          id, body.name, way, 0.5 * smallest, 0.5 * smallest / way * update->dt)};
  }
  return {};
}

double FixWall::take_largest_overlap() { return std::exchange(largest_overlap_, 0.0); }

void FixWall::read_materials() {
  PropertyRegistry& registry = force->registry;
  const auto connect = [&](const char* name, MatrixPropertyCreator create, double**& values) {
    registry.registerProperty(name, create);
    registry.connect(name, values, "fix granary/wall");
  };
  connect("Yeff", &MODEL_PARAMS::createYeff, young_);
  connect("Geff", &MODEL_PARAMS::createGeff, shear_);
  connect("betaeff", &MODEL_PARAMS::createBetaEff, damping_);
  connect("coeffFrict", &MODEL_PARAMS::createCoeffFrict, friction_);
  if (rolling_ != RollingModel::none) connect("coeffRollFrict", &MODEL_PARAMS::createCoeffRollFrict, rolling_friction_);
  if (cohesion_) connect("cohEnergyDens", &MODEL_PARAMS::createCohesionEnergyDensity, cohesion_density_);

  materials_.assign(static_cast<std::size_t>(atom->ntypes) + 1, {});
  for (int t = 1; t <= atom->ntypes; ++t) {
    materials_[static_cast<std::size_t>(t)] = {
        .young = young_[t][type_],
        .shear = shear_[t][type_],
        .damping = damping_[t][type_],
        .friction = friction_[t][type_],
        .rolling_friction = rolling_ != RollingModel::none ? rolling_friction_[t][type_] : 0.0,
        .cohesion = cohesion_ ? cohesion_density_[t][type_] : 0.0};
  }
}

// What touches when a run starts has begun before it.
void FixWall::setup(int) { push(true); }
void FixWall::post_force(int) { push(false); }

void FixWall::turn_bodies() {
  const auto step = static_cast<long>(update->ntimestep);
  for (Body& body : bodies_) {
    body.turned = body.start_angle != 0.0 || body.angle_per_step != 0.0;
    if (body.turned) body.turn = Turn::about(body.rotation.axis, body.angle(step));
  }
}

void FixWall::push(bool frozen) {
  turn_bodies();
  for (Body& body : bodies_) std::fill_n(body.sums, 7, 0.0);
  summed_step_ = -1;

  for (int i = 0; i < atom->nlocal; ++i) {
    if (!(atom->mask[i] & groupbit)) continue;
    TouchBook::Page& before = book_.page(static_cast<std::size_t>(i));
    const Vector3 place = vector_of(atom->x[i]);
    now_.n = 0;
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      Look& look = looks_[first_look_of(i) + b];
      const Vector3 here = bodies_[b].turned ? bodies_[b].to_body(place) : place, moved = here - look.place;
      const double room = look.clear_distance - atom->radius[i];
      if (room > 0.0 && dot(moved, moved) < room * room) continue;
      look = {here, bodies_[b].surface->touches(here, atom->radius[i], nearby_[first_look_of(i) + b], found_)};
      if (!found_.empty()) push(i, b, before, frozen);
    }
    before.n = now_.n;
    std::copy_n(now_.touch.begin(), now_.n, before.touch.begin());
  }
}

void FixWall::push(int i, std::size_t b, TouchBook::Page& before, bool frozen) {
  Body& body = bodies_[b];
  const auto number = static_cast<double>(b);
  const Vector3 wall_spin = body.rotation.rate * body.rotation.axis;  // the same in both frames
  const Vector3 velocity = body.turn.to_body(vector_of(atom->v[i]));
  const bool impact = !frozen && !before.touched(number);

  for (const SurfaceTouch& touch : found_) {
    const WallApproach approach{.radius = atom->radius[i],
                                .mass = atom->rmass[i],
                                .overlap = atom->radius[i] - touch.distance,
                                .normal = touch.normal,
                                .velocity = velocity - cross(wall_spin, touch.point - body.rotation.origin),
                                .spin = body.turn.to_body(vector_of(atom->omega[i])),
                                .wall_spin = wall_spin};
    largest_overlap_ = std::max(largest_overlap_, approach.overlap / approach.radius);
    RememberedTouch remembered = before.take(number, touch.normal);
    const WallForce pushed = wall_force(materials_[static_cast<std::size_t>(atom->type[i])], rolling_, approach,
                                        update->dt, frozen, remembered.history);
    if (!now_.note(remembered) && !said_full_) {
      said_full_ = true;
      error->warning(FLERR,
                     "granary/wall: a particle touches bodies at more than 6 places: further ones keep no history");
    }
    const Vector3 push = body.turn.to_lab(pushed.force), torque = body.turn.to_lab(pushed.torque);
    add(atom->f[i], push);
    add(atom->torque[i], torque);

    const Vector3 moment = cross(vector_of(atom->x[i]) - body.rotation.origin, push) + torque;
    add(body.sums, -1.0 * push);
    add(body.sums + 3, -1.0 * moment);
    body.sums[6] += dot(moment, wall_spin);
    if (impact && &touch == found_.data()) {
      const double speed = std::max(0.0, -dot(approach.velocity, approach.normal));
      body.sums[7] += 1.0;
      body.sums[8] += speed;
      if (listener_) listener_(b, i, speed);
    }
  }
}

double FixWall::compute_vector(int n) {
  const auto step = static_cast<long>(update->ntimestep);
  if (summed_step_ != step) {
    summed_.clear();
    for (const Body& body : bodies_) summed_.insert(summed_.end(), body.sums, body.sums + kSums);
    MPI_Allreduce(MPI_IN_PLACE, summed_.data(), static_cast<int>(summed_.size()), MPI_DOUBLE, MPI_SUM, world);
    summed_step_ = step;
  }
  return summed_[static_cast<std::size_t>(n)];
}

// ---- for the tally and the guard ----

class FixWall::BodyWall : public Wall {
 public:
  BodyWall(FixWall& fix, Body& body) : fix_(fix), body_(body) { fix_index = fix.modify->my_index(&fix); }

  void touches(const std::function<void(const WallTouch&)>& found) const override {
    const LAMMPS_NS::Atom& atom = *fix_.atom;
    std::vector<SurfaceTouch> touching;
    const Vector3 spin = body_.rotation.rate * body_.rotation.axis;
    const auto number = static_cast<std::size_t>(&body_ - fix_.bodies_.data());
    for (int i = 0; i < atom.nlocal; ++i) {
      if (!(atom.mask[i] & fix_.groupbit)) continue;
      const Vector3 here = body_.to_body(vector_of(atom.x[i]));
      const std::size_t at = fix_.first_look_of(i) + number;
      const Vector3 moved = here - fix_.looks_[at].place;
      const double room = fix_.looks_[at].clear_distance - atom.radius[i];
      if (room > 0.0 && dot(moved, moved) < room * room) continue;
      body_.surface->touches(here, atom.radius[i], fix_.nearby_[at], touching);
      if (touching.empty()) continue;
      const SurfaceTouch& deepest = touching[0];
      found({.particle = i,
             .overlap = (atom.radius[i] - deepest.distance) / atom.radius[i],
             .normal = body_.turn.to_lab(deepest.normal),
             .velocity = cross(spin, body_.to_lab(deepest.point) - body_.rotation.origin)});
    }
  }

 private:
  FixWall& fix_;
  Body& body_;
};

std::vector<std::string> FixWall::body_names() const {
  std::vector<std::string> names;
  for (const Body& body : bodies_) names.push_back(body.name);
  return names;
}

std::unique_ptr<Wall> FixWall::body(const std::string& name) {
  for (Body& body : bodies_)
    if (body.name == name) return std::make_unique<BodyWall>(*this, body);
  return nullptr;
}

FixWall::Load FixWall::load(std::size_t b) const {
  const Body& body = bodies_[b];
  const Vector3 torque = vector_of(body.sums + 3);
  return {vector_of(body.sums), torque, dot(torque, body.rotation.axis), body.sums[6]};
}

std::vector<Triangle> FixWall::triangles(std::size_t b) {
  turn_bodies();
  std::vector<Triangle> triangles = bodies_[b].surface->triangles();
  for (Triangle& triangle : triangles)
    for (Vector3& corner : triangle) corner = bodies_[b].to_lab(corner);
  return triangles;
}

// ---- memory that follows the particles ----

void FixWall::grow_arrays(int n) {
  book_.resize(static_cast<std::size_t>(n));
  looks_.resize(first_look_of(n));
  nearby_.resize(first_look_of(n));
}
void FixWall::copy_arrays(int from, int to, int) {
  book_.copy(static_cast<std::size_t>(from), static_cast<std::size_t>(to));
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    looks_[first_look_of(to) + b] = looks_[first_look_of(from) + b];
    nearby_[first_look_of(to) + b] = nearby_[first_look_of(from) + b];
  }
}
void FixWall::forget_looks(int particle) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    looks_[first_look_of(particle) + b].clear_distance = 0.0;
    nearby_[first_look_of(particle) + b].complete = 0.0;
  }
}

void FixWall::set_arrays(int particle) {
  book_.clear(static_cast<std::size_t>(particle));
  forget_looks(particle);
}

int FixWall::pack_exchange(int particle, double* buffer) {
  return static_cast<int>(book_.pack(static_cast<std::size_t>(particle), buffer));
}

int FixWall::unpack_exchange(int particle, double* buffer) {
  forget_looks(particle);
  return static_cast<int>(book_.unpack(static_cast<std::size_t>(particle), buffer));
}

// LIGGGHTS wants the length first.
int FixWall::pack_restart(int particle, double* buffer) {
  buffer[0] = static_cast<double>(size_restart(particle));
  book_.pack(static_cast<std::size_t>(particle), buffer + 1);
  return size_restart(particle);
}

// Our values come after those of nth other fixes.
void FixWall::unpack_restart(int particle, int nth) {
  forget_looks(particle);
  const double* values = atom->extra[particle];
  for (int k = 0; k < nth; ++k) values += static_cast<int>(values[0]);
  book_.unpack(static_cast<std::size_t>(particle), values + 1);
}

int FixWall::size_restart(int particle) {
  return 1 + static_cast<int>(book_.packed_size(static_cast<std::size_t>(particle)));
}

int FixWall::maxsize_restart() { return 1 + static_cast<int>(TouchBook::kMostPacked); }

void FixWall::write_restart(FILE* file) {
  if (comm->me != 0) return;
  std::vector<double> state;
  for (const Body& body : bodies_) {
    state.push_back(body.start_angle);
    state.push_back(static_cast<double>(body.start_step));
    state.push_back(body.angle_per_step);
  }
  const int size = static_cast<int>((state.size() + 1) * sizeof(double));
  const auto n_bodies = static_cast<double>(bodies_.size());
  fwrite(&size, sizeof size, 1, file);
  fwrite(&n_bodies, sizeof n_bodies, 1, file);
  fwrite(state.data(), sizeof(double), state.size(), file);
}

void FixWall::restart(char* state) {
  const auto* values = reinterpret_cast<const double*>(state);
  if (static_cast<std::size_t>(values[0]) != bodies_.size())
    end_if_failed(world, Error{"fix " + std::string(id) + " (granary/wall): the restart file has " +
                               std::to_string(static_cast<int>(values[0])) + " bodies, the input script " +
                               std::to_string(bodies_.size()) + ". Give the same ones. See docs/dem_styles.md."});
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    bodies_[b].start_angle = values[1 + 3 * b];
    bodies_[b].start_step = static_cast<long>(values[2 + 3 * b]);
    bodies_[b].angle_per_step = values[3 + 3 * b];
  }
}

}  // namespace granary::dem
