#include "dem_templates/plugin/wall/fix_wall.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
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

#include "common/files.hpp"
#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_words.hpp"
#include "dem_templates/plugin/wall/time_step_limits.hpp"

namespace granary::dem {
namespace {

void add(double* to, const Vector3& v) {
  for (std::size_t d = 0; d < 3; ++d) to[d] += v[d];
}

constexpr double kBitLarger = 1.01;  // than a sphere: one that is about to touch is seen
constexpr double kSameSide = 0.9;    // cosine

}  // namespace

FixWall::FixWall(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : Fix(lammps, narg, arg) {
  FixArguments arguments(fix_words(narg, arg), wall_keywords());
  WallSettings settings = read_wall_settings(arguments);
  end_if_failed(world, arguments.status());
  type_ = settings.type;
  rolling_ = settings.rolling;
  cohesion_ = settings.cohesion;
  pushes_ = settings.pushes;
  bodies_ = std::move(settings.bodies);
  watches_.resize(bodies_.size());
  sums_.assign(bodies_.size(), {});
  wear_settings_ = settings.wear;
  if (wear_settings_.on())
    for (const WallBody& body : bodies_) wear_.emplace_back(body.surface->n_parts());

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

int FixWall::setmask() { return LAMMPS_NS::FixConst::POST_FORCE | LAMMPS_NS::FixConst::POST_RUN; }

void FixWall::init() {
  const std::string place = "fix " + std::string(id) + " (granary/wall): ";
  if (!atom->sphere_flag || !atom->radius || !atom->rmass)
    end_if_failed(world, Error{place + "needs spheres: 'atom_style granular'. See docs/dem_styles.md."});
  if (type_ > atom->ntypes)
    end_if_failed(world, Error{place + "type " + std::to_string(type_) + " is above the " +
                               std::to_string(atom->ntypes) + " type(s) of the box. See docs/dem_styles.md."});
  read_materials();
  rows_ = WallRows(rolling_);

  for (WallBody& body : bodies_) body.start(static_cast<long>(update->ntimestep), update->dt);
}

Status FixWall::check_time_step() const {
  std::string problems;
  for (const WallBody& body : bodies_) {
    const double tip_speed = body.tip_speed();
    double smallest = std::numeric_limits<double>::infinity(), shortest = smallest;
    for (int i = 0; i < atom->nlocal; ++i) {
      const double speed = tip_speed + norm(vector_of(atom->v[i])), radius = atom->radius[i];
      const double young = materials_[static_cast<std::size_t>(atom->type[i])].young;
      smallest = std::min(smallest, radius);
      if (speed > 0.0) shortest = std::min(shortest, hertz_contact_time(young, radius, atom->rmass[i], speed));
    }
    problems += time_step_problems(body, smallest, shortest, update->dt);
  }
  if (problems.empty()) return {};
  return Error{"fix " + std::string(id) + " (granary/wall): the time step is too long:" + problems +
               "\n  See docs/dem_styles.md."};
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
  for (int t = 1; t <= registry.max_type(); ++t) {  // what no particle and no wall has, LIGGGHTS makes no numbers for
    materials_[static_cast<std::size_t>(t)] = {
        .young = young_[t][type_],
        .shear = shear_[t][type_],
        .damping = damping_[t][type_],
        .friction = friction_[t][type_],
        .rolling_friction = rolling_ != RollingModel::none ? rolling_friction_[t][type_] : 0.0,
        .cohesion = cohesion_ ? cohesion_density_[t][type_] : 0.0};
  }
}

// What touches when a run starts has begun before it. Radii may have changed since the last one.
void FixWall::setup(int) {
  end_if_failed(world, check_time_step());
  for (Watch& watch : watches_) watch.forget_all();
  push(true);
}
void FixWall::post_force(int) {
  push(false);
  if (wear_settings_.every > 0 && update->ntimestep % wear_settings_.every == 0) write_wear();
}
void FixWall::post_run() { write_wear(); }

void FixWall::turn_bodies() {
  for (WallBody& body : bodies_) body.turn_to(static_cast<long>(update->ntimestep));
}

template <class Done>
void FixWall::look_at_due(std::size_t b, Done&& done) {
  const auto n_particles = static_cast<std::size_t>(atom->nlocal);
  if (n_particles == 0) return;
  const WallBody& body = bodies_[b];
  Watch& watch = watches_[b];
  const double *places = atom->x[0], *radii = atom->radius;
  const std::vector<std::uint32_t>& due = watch.due(body, places, n_particles);
  for (std::size_t first = 0; first < due.size(); first += kMostLooks) {
    std::size_t n_looks = 0;
    for (const std::uint32_t i : std::span(due).subspan(first, std::min(kMostLooks, due.size() - first))) {
      if (!(atom->mask[i] & groupbit)) continue;
      watch.fetch(i);
      book_.fetch(i);
      const Vector3 place = vector_of(places + 3 * i);
      Look& look = looks_[n_looks++];
      look.centre = body.turned ? body.to_body(place) : place;
      look.radius = radii[i];
      look.nearby = &watch.nearby(i);
      look.particle = i;
    }
    const std::span<Look> looks(looks_.data(), n_looks);
    body.surface->look(looks, found_);
    done(std::span<const Look>(looks));
  }
}

void FixWall::push(bool frozen) {
  turn_bodies();
  summed_step_ = -1;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Watch& watch = watches_[b];
    std::fill_n(sums_[b].begin(), 7, 0.0);
    look_at_due(b, [&](std::span<const Look> looks) {
      for (const Look& look : looks) {
        if (watch.may_have_passed(look.particle, look.centre, look.radius)) refuse_if_passed(b, look);
        watch.looked(look.particle, look.centre, look.radius, look.clear, look.n);
        if (look.n == 0)
          book_.page(look.particle).forget(static_cast<std::uint8_t>(b));
        else
          queue(b, look, frozen);
      }
      push_queued(b, frozen);
    });
  }
}

void FixWall::refuse_if_passed(std::size_t b, const Look& look) {
  const WallBody& body = bodies_[b];
  const Vector3 before = watches_[b].last_place(look.particle), here = look.centre;
  const std::uint32_t i = look.particle;
  if (!body.surface->between(before, here)) return;
  const double speed = norm(body.turn.to_body(vector_of(atom->v[i])) - body.velocity_at(here));
  error->one(FLERR,
             fmt::format("fix {} (granary/wall): at step {} particle {} has gone through body '{}' within a step: "
                         "it moves {:.3g} m towards it in one, its radius is {:.3g} m. Take a time "
                         "step below {:.3g} s. See docs/dem_styles.md.",
                         id, update->ntimestep, atom->tag[i], body.name, speed * update->dt, atom->radius[i],
                         0.5 * atom->radius[i] / speed)
                 .c_str());
}

void FixWall::queue(std::size_t b, const Look& look, bool frozen) {
  const auto i = static_cast<int>(look.particle);
  const std::span<const SurfaceTouch> touches = std::span(found_).subspan(look.first, look.n);
  TouchBook::Page& page = book_.page(look.particle);
  if (slots_.size() < touches.size()) slots_.resize(touches.size());
  bool impact = !page.go_on(static_cast<std::uint8_t>(b), touches, slots_.data()) && !frozen;
  const ContactMaterial& material = materials_[static_cast<std::size_t>(atom->type[i])];
  const double mass = atom->rmass[i];
  const double *velocity = atom->v[0] + 3 * i, *spin = atom->omega[0] + 3 * i;
  for (std::size_t k = 0; k < touches.size(); ++k) {
    const SurfaceTouch& touch = touches[k];
    if (rows_.full()) push_queued(b, frozen);
    const std::size_t slot = slots_[k];
    Queued& queued = queued_[rows_.size()];
    queued.particle = i;
    queued.begins = std::exchange(impact, false);
    queued.touch = &touch;
    const bool has_place = slot < TouchBook::kMost;
    queued.shear = has_place ? &page.place[slot].shear : &unknown_.shear;
    queued.rolling_torque = has_place ? &page.rolling[slot] : &unknown_.rolling_torque;
    if (!has_place) say_full();
    rows_.add(material, {.radius = look.radius,
                         .mass = mass,
                         .overlap = look.radius - touch.distance,
                         .normal = touch.normal.data(),
                         .point = touch.point.data(),
                         .velocity = velocity,
                         .spin = spin,
                         .shear = queued.shear->data(),
                         .rolling_torque = queued.rolling_torque->data()});
  }
  if (!touch_listener_) return;
  for (const SurfaceTouch& touch : touches) touch_listener_(b, i, (look.radius - touch.distance) / look.radius);
}

void FixWall::say_full() {
  if (std::exchange(said_full_, true)) return;
  error->warning(FLERR, "granary/wall: a particle touches bodies at more than 6 places: further ones keep no history");
}

void FixWall::push_queued(std::size_t b, bool frozen) {
  const WallBody& body = bodies_[b];
  std::array<double, kSums>& sums = sums_[b];
  const WallRows::Sums all = rows_.advance({body.turn, body.spin(), body.rotation.origin}, update->dt, frozen);
  double *forces = atom->f[0], *torques = atom->torque[0];
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Queued& queued = queued_[k];
    if (pushes_) {
      add(forces + 3 * queued.particle, rows_.force(k));
      add(torques + 3 * queued.particle, rows_.torque(k));
    }
    if (frozen) continue;
    *queued.shear = rows_.shear(k);
    if (rolling_ == RollingModel::epsd2) *queued.rolling_torque = rows_.rolling_torque(k);
    if (!wear_.empty()) wear_off(b, k);
    if (!queued.begins) continue;
    const double speed = impact_speed(b, k);
    if (!(speed > 0.0)) continue;  // begun while parting, as a pinched particle does in step after step: no impact
    sums[7] += 1.0;
    sums[8] += speed;
    if (listener_) listener_(b, queued.particle, speed);
  }
  rows_.clear();
  unknown_ = {};
  largest_overlap_ = std::max(largest_overlap_, all.deepest);
  add(&sums[0], -1.0 * all.force);
  add(&sums[3], -1.0 * all.moment);
  sums[6] += dot(all.moment, body.spin());
}

// On a face the normal is the same all the way in; at an edge or a corner it turns, and a later one sees less of the
// speed: 2 % of a mixer's mean in steps of a fifteenth of the contact time.
double FixWall::impact_speed(std::size_t b, std::size_t k) {
  const double seen = -rows_.normal_speed(k);
  if (!(seen > 0.0)) return seen;
  const WallBody& body = bodies_[b];
  const Queued& queued = queued_[k];
  const SurfaceTouch& touch = *queued.touch;
  const double radius = atom->radius[queued.particle];
  const Vector3 velocity = body.turn.to_body(vector_of(atom->v[queued.particle])) - body.velocity_at(touch.point);
  const double ago = std::min((radius - touch.distance) / seen, update->dt);
  Nearby nearby;
  Look look{.centre = touch.point + touch.distance * touch.normal - ago * velocity,
            .radius = kBitLarger * radius,
            .nearby = &nearby,
            .particle = static_cast<std::uint32_t>(queued.particle)};
  body.surface->look({&look, 1}, first_);
  double likeness = kSameSide, speed = seen;
  for (const SurfaceTouch& first : first_) {
    const double alike = dot(first.normal, touch.normal);
    if (alike <= likeness) continue;
    likeness = alike;
    speed = -dot(velocity, first.normal);
  }
  return speed > 0.0 ? speed : seen;
}

void FixWall::wear_off(std::size_t b, std::size_t k) {
  Wear& wear = wear_[b];
  if (wear.by_sliding.empty()) return;  // no mesh
  const Queued& queued = queued_[k];
  const std::size_t part = bodies_[b].surface->part_at(*queued.touch);
  wear.by_sliding[part] +=
      archard_volume(wear_settings_.archard, rows_.normal_force(k), rows_.slip_speed(k) * update->dt);
  if (queued.begins)
    wear.by_impacts[part] +=
        finnie_volume(wear_settings_.finnie, atom->rmass[queued.particle], rows_.speed(k), -rows_.normal_speed(k));
}

Wear FixWall::wear_of_all_ranks(std::size_t b) const {
  Wear all(wear_[b].by_sliding.size());
  const auto n = static_cast<int>(all.by_sliding.size());
  MPI_Reduce(wear_[b].by_sliding.data(), all.by_sliding.data(), n, MPI_DOUBLE, MPI_SUM, 0, world);
  MPI_Reduce(wear_[b].by_impacts.data(), all.by_impacts.data(), n, MPI_DOUBLE, MPI_SUM, 0, world);
  return all;
}

void FixWall::write_wear() {
  const auto step = static_cast<long>(update->ntimestep);
  if (wear_.empty() || step == wear_written_) return;
  wear_written_ = step;
  Status written;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Wear wear = wear_of_all_ranks(b);
    if (comm->me != 0 || wear.by_sliding.empty() || !written) continue;
    const std::string& name = bodies_[b].name;
    written = write_text_atomically(fmt::format("{}_{}_{}.vtk", wear_settings_.file, name, step),
                                    wear_vtk(triangles(b), wear, fmt::format("wear of {} at step {}", name, step)));
  }
  end_if_failed(world, written);
}

double FixWall::compute_vector(int n) {
  const auto step = static_cast<long>(update->ntimestep);
  if (summed_step_ != step) {
    summed_.clear();
    for (const auto& sums : sums_) summed_.insert(summed_.end(), sums.begin(), sums.end());
    MPI_Allreduce(MPI_IN_PLACE, summed_.data(), static_cast<int>(summed_.size()), MPI_DOUBLE, MPI_SUM, world);
    summed_step_ = step;
  }
  return summed_[static_cast<std::size_t>(n)];
}

// ---- for the tally and the guard ----

class FixWall::BodyWall : public Wall {
 public:
  BodyWall(FixWall& fix, std::size_t b) : fix_(fix), b_(b) { fix_index = fix.modify->my_index(&fix); }

  // Only who is due can touch: the others were clear of it when it pushed in this step.
  void touches(const std::function<void(const WallTouch&)>& found) const override {
    const WallBody& body = fix_.bodies_[b_];
    fix_.look_at_due(b_, [&](std::span<const Look> looks) {
      for (const Look& look : looks) {
        if (look.n == 0) continue;
        const SurfaceTouch& deepest = fix_.found_[look.first];
        found({.particle = static_cast<int>(look.particle),
               .overlap = (look.radius - deepest.distance) / look.radius,
               .normal = body.turn.to_lab(deepest.normal),
               .velocity = body.turn.to_lab(body.velocity_at(deepest.point))});
      }
    });
  }

 private:
  FixWall& fix_;
  std::size_t b_;
};

std::vector<std::string> FixWall::body_names() const {
  std::vector<std::string> names;
  for (const WallBody& body : bodies_) names.push_back(body.name);
  return names;
}

std::unique_ptr<Wall> FixWall::body(const std::string& name) {
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (bodies_[b].name == name) return std::make_unique<BodyWall>(*this, b);
  return nullptr;
}

FixWall::Load FixWall::load(std::size_t b) const {
  const WallBody& body = bodies_[b];
  const std::array<double, kSums>& sums = sums_[b];
  const Vector3 torque = vector_of(&sums[3]);
  return {vector_of(&sums[0]), torque, dot(torque, body.rotation.axis), sums[6]};
}

std::vector<Triangle> FixWall::triangles(std::size_t b) {
  turn_bodies();
  std::vector<Triangle> triangles = bodies_[b].surface->triangles();
  for (Triangle& triangle : triangles)
    for (Vector3& corner : triangle) corner = bodies_[b].to_lab(corner);
  return triangles;
}

}  // namespace granary::dem
