#include "dem_templates/plugin/resize/packing.hpp"

#include <algorithm>
#include <cmath>

namespace granary::dem {
namespace {

constexpr double kFarthestMove = 0.25;  // of its radius, per sweep
constexpr double kSkin = 0.3;           // of the mean radius: how far neighbours are looked for beyond touching
constexpr int kPatience = 400;          // sweeps without a gain: what is left is trapped
constexpr double kGain = 0.95;
constexpr int kSweepsBetweenChecks = 5;

double cube(double x) { return x * x * x; }

struct Pair {
  int a, b;
};

double largest_radius(const std::vector<Sphere>& spheres) {
  double largest = 0.0;
  for (const Sphere& sphere : spheres) largest = std::max(largest, sphere.radius);
  return largest;
}

class Relaxer {
 public:
  Relaxer(std::vector<Sphere>& spheres, const FreeSpace& space, int axis)
      : spheres_(spheres),
        space_(space),
        axis_(static_cast<std::size_t>(axis)),
        start_(spheres.size()),
        listed_at_(spheres.size()),
        near_wall_(spheres.size()) {
    double sum = 0.0;
    for (const Sphere& sphere : spheres) sum += sphere.radius;
    skin_ = kSkin * sum / static_cast<double>(spheres.size());
    list_neighbours();
  }

  void sweep() {
    for (std::size_t s = 0; s < spheres_.size(); ++s) start_[s] = spheres_[s].centre;
    for (const Pair& pair : pairs_)
      push_apart(spheres_[static_cast<std::size_t>(pair.a)], spheres_[static_cast<std::size_t>(pair.b)]);
    for (std::size_t s = 0; s < spheres_.size(); ++s) hold(s);
    for (std::size_t s = 0; s < spheres_.size(); ++s) {
      if (norm(spheres_[s].centre - listed_at_[s]) > 0.5 * skin_) return list_neighbours();
    }
  }

  double worst_overlap() {
    double worst = 0.0;
    for (const Pair& pair : pairs_) {
      const Sphere& a = spheres_[static_cast<std::size_t>(pair.a)];
      const Sphere& b = spheres_[static_cast<std::size_t>(pair.b)];
      worst = std::max(worst, (a.radius + b.radius - norm(a.centre - b.centre)) / std::min(a.radius, b.radius));
    }
    for (std::size_t s = 0; s < spheres_.size(); ++s) {
      if (!near_wall_[s]) continue;
      walls_.clear();
      space_.walls_near(spheres_[s].centre, spheres_[s].radius, walls_);
      for (const NearWall& wall : walls_) worst = std::max(worst, 1.0 - wall.distance / spheres_[s].radius);
    }
    return worst;
  }

 private:
  void list_neighbours() {
    pairs_.clear();
    SphereGrid grid(space_.low(), space_.high(), 2.0 * largest_radius(spheres_) + skin_);
    for (std::size_t s = 0; s < spheres_.size(); ++s) {
      const Sphere& sphere = spheres_[s];
      grid.around(sphere.centre, [&](int other) {
        const Sphere& before = spheres_[static_cast<std::size_t>(other)];
        const Vector3 away = sphere.centre - before.centre;
        const double near = sphere.radius + before.radius + skin_;
        if (dot(away, away) < near * near) pairs_.push_back({other, static_cast<int>(s)});
      });
      grid.add(static_cast<int>(s), sphere.centre);
      listed_at_[s] = sphere.centre;

      walls_.clear();
      space_.walls_near(sphere.centre, sphere.radius + skin_, walls_);
      near_wall_[s] = !walls_.empty();
    }
  }

  static void push_apart(Sphere& a, Sphere& b) {
    const Vector3 away = b.centre - a.centre;
    const double touching = a.radius + b.radius, distance2 = dot(away, away);
    if (distance2 >= touching * touching) return;
    const double distance = std::sqrt(distance2);
    const Vector3 normal = distance > 0.0 ? (1.0 / distance) * away : Vector3{0.0, 0.0, 1.0};
    const double weight_a = cube(a.radius), weight_b = cube(b.radius), overlap = touching - distance;
    a.centre = a.centre - (overlap * weight_b / (weight_a + weight_b)) * normal;
    b.centre = b.centre + (overlap * weight_a / (weight_a + weight_b)) * normal;
  }

  // Not too far from where it was, off the walls, in its compartment and in the space.
  void hold(std::size_t s) {
    Sphere& sphere = spheres_[s];
    const Vector3 moved = sphere.centre - start_[s];
    const double distance = norm(moved), farthest = kFarthestMove * sphere.radius;
    if (distance > farthest) sphere.centre = start_[s] + (farthest / distance) * moved;

    if (near_wall_[s]) push_off_walls(sphere);
    sphere.centre[axis_] = std::clamp(sphere.centre[axis_], sphere.axial_low, sphere.axial_high);
    if (near_wall_[s] && !space_.inside(sphere.centre) && space_.inside(start_[s])) sphere.centre = start_[s];
  }

  // The deepest wall first: two triangles that share an edge push once. Three walls make a corner.
  void push_off_walls(Sphere& sphere) {
    for (int corner = 0; corner < 3; ++corner) {
      walls_.clear();
      space_.walls_near(sphere.centre, sphere.radius, walls_);
      if (walls_.empty()) return;
      const NearWall& deepest = *std::min_element(
          walls_.begin(), walls_.end(), [](const NearWall& a, const NearWall& b) { return a.distance < b.distance; });
      sphere.centre = sphere.centre + (sphere.radius - deepest.distance) * deepest.normal;
    }
  }

  std::vector<Sphere>& spheres_;
  const FreeSpace& space_;
  std::size_t axis_;
  double skin_ = 0.0;
  std::vector<Pair> pairs_;
  std::vector<Vector3> start_;      // of this sweep
  std::vector<Vector3> listed_at_;  // when pairs_ was made
  std::vector<bool> near_wall_;
  std::vector<NearWall> walls_;
};

}  // namespace

SphereGrid::SphereGrid(const Vector3& low, const Vector3& high, double reach) : low_(low), size_(reach) {
  // Not many more cells than a few millions, however small the spheres are.
  for (std::size_t d = 0; d < 3; ++d) size_ = std::max(size_, (high[d] - low[d]) / 200.0);
  for (std::size_t d = 0; d < 3; ++d) n_[d] = static_cast<long>((high[d] - low[d]) / size_) + 1;
  cells_.resize(static_cast<std::size_t>(n_[0] * n_[1] * n_[2]));
}

void SphereGrid::add(int sphere, const Vector3& centre) { cells_[index(cell_of(centre))].push_back(sphere); }

void SphereGrid::clear() {
  for (auto& cell : cells_) cell.clear();
}

SphereGrid::Cell SphereGrid::cell_of(const Vector3& point) const {
  long c[3];
  for (std::size_t d = 0; d < 3; ++d)
    c[d] = std::clamp(static_cast<long>(std::floor((point[d] - low_[d]) / size_)), 0L, n_[d] - 1);
  return {c[0], c[1], c[2]};
}

double largest_overlap(const std::vector<Sphere>& spheres, const FreeSpace& space) {
  if (spheres.empty()) return 0.0;
  std::vector<Sphere> copy = spheres;
  return Relaxer(copy, space, 0).worst_overlap();
}

Relaxation relax(std::vector<Sphere>& spheres, const FreeSpace& space, int axis, double tolerance, int most_sweeps) {
  if (spheres.empty()) return {};
  Relaxer relaxer(spheres, space, axis);
  Relaxation done{0, relaxer.worst_overlap()};
  double last_gain = done.overlap;
  int since_gain = 0;
  while (done.overlap > tolerance && done.sweeps < most_sweeps && since_gain < kPatience) {
    for (int s = 0; s < kSweepsBetweenChecks; ++s) relaxer.sweep();
    done.sweeps += kSweepsBetweenChecks;
    since_gain += kSweepsBetweenChecks;
    done.overlap = relaxer.worst_overlap();
    if (done.overlap < kGain * last_gain) last_gain = done.overlap, since_gain = 0;
  }
  return done;
}

}  // namespace granary::dem
