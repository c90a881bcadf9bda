#include "dem_templates/plugin/resize/packing.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace granary::dem {
namespace {

constexpr double kFarthestMove = 0.25;  // of its radius, per sweep
constexpr double kSkin = 1.0;           // of the mean radius: how far neighbours are looked for beyond touching
constexpr int kPatience = 400;          // sweeps without a gain: what is left is trapped
constexpr double kGain = 0.95;
constexpr int kSweepsBetweenChecks = 5;
constexpr double kSlack = 0.1;  // of the tolerance: overlaps so small are left alone

double cube(double x) { return x * x * x; }

double largest_radius(const std::vector<Sphere>& spheres) {
  double largest = 0.0;
  for (const Sphere& sphere : spheres) largest = std::max(largest, sphere.radius);
  return largest;
}

double mean_radius(const std::vector<Sphere>& spheres) {
  double sum = 0.0;
  for (const Sphere& sphere : spheres) sum += sphere.radius;
  return sum / static_cast<double>(spheres.size());
}

// Only spheres that were moved in the last sweep, or should have been, are looked at in the next: the others overlap
// by no more than the slack, and nothing has come nearer. So a few that are trapped cost nothing but themselves.
class Relaxer {
 public:
  /// slack: overlaps up to this fraction of the (smaller) radius are left alone.
  Relaxer(std::vector<Sphere>& spheres, const FreeSpace& space, int axis, double slack)
      : spheres_(spheres),
        space_(space),
        axis_(static_cast<std::size_t>(axis)),
        slack_(slack),
        skin_(kSkin * mean_radius(spheres)),
        grid_(space.low(), space.high(), 2.0 * largest_radius(spheres) + skin_),
        start_(spheres.size()),
        listed_at_(spheres.size()),
        near_(spheres.size()),
        near_wall_(spheres.size()),
        is_seen_(spheres.size(), false),
        is_pushed_(spheres.size(), false) {
    for (std::size_t s = 0; s < spheres_.size(); ++s) list(s);
    look_at_all();
  }

  void look_at_all() {
    active_.resize(spheres_.size());
    is_active_.assign(spheres_.size(), true);
    std::iota(active_.begin(), active_.end(), std::size_t{0});
  }

  void sweep() {
    seen_.clear();
    for (const std::size_t s : active_) see(s);
    for (const std::size_t s : active_)
      for (const std::size_t other : near_[s])
        if (other > s || !is_active_[other]) push_apart(s, other);
    for (const std::size_t s : seen_) hold(s);

    active_.clear();
    for (const std::size_t s : seen_) {
      if (is_pushed_[s]) active_.push_back(s);
      is_active_[s] = is_pushed_[s];
      is_seen_[s] = is_pushed_[s] = false;
    }
  }

  /// Of the spheres that the next sweep would look at.
  double worst_overlap() {
    double worst = 0.0;
    for (const std::size_t s : active_) {
      const Sphere& a = spheres_[s];
      for (const std::size_t other : near_[s]) {
        const Sphere& b = spheres_[other];
        worst = std::max(worst, (a.radius + b.radius - norm(a.centre - b.centre)) / std::min(a.radius, b.radius));
      }
      if (!near_wall_[s]) continue;
      walls_.clear();
      space_.walls_near(a.centre, a.radius, walls_);
      for (const NearWall& wall : walls_) worst = std::max(worst, 1.0 - wall.distance / a.radius);
    }
    return worst;
  }

 private:
  // Who may touch a sphere until it, or they, have moved by half the skin. All lists go by the places of listing.
  void list(std::size_t s) {
    const Sphere& sphere = spheres_[s];
    grid_.add(static_cast<int>(s), sphere.centre);
    listed_at_[s] = sphere.centre;
    grid_.around(sphere.centre, [&](int found) {
      const auto other = static_cast<std::size_t>(found);
      const Vector3 away = sphere.centre - listed_at_[other];
      const double near = sphere.radius + spheres_[other].radius + skin_;
      if (other == s || dot(away, away) >= near * near) return;
      near_[s].push_back(other);
      near_[other].push_back(s);
    });
    walls_.clear();
    space_.walls_near(sphere.centre, sphere.radius + skin_, walls_);
    near_wall_[s] = !walls_.empty();
  }

  void list_anew_if_far(std::size_t s) {
    if (norm(spheres_[s].centre - listed_at_[s]) <= 0.5 * skin_) return;
    grid_.remove(static_cast<int>(s), listed_at_[s]);
    for (const std::size_t other : near_[s]) std::erase(near_[other], s);
    near_[s].clear();
    list(s);
  }

  void see(std::size_t s) {
    if (is_seen_[s]) return;
    is_seen_[s] = true;
    start_[s] = spheres_[s].centre;
    seen_.push_back(s);
  }

  void push_apart(std::size_t s, std::size_t other) {
    Sphere &a = spheres_[s], &b = spheres_[other];
    const Vector3 away = b.centre - a.centre;
    const double touching = a.radius + b.radius, near = touching - slack_ * std::min(a.radius, b.radius);
    const double distance2 = dot(away, away);
    if (distance2 >= near * near) return;
    const double distance = std::sqrt(distance2);
    const Vector3 normal = distance > 0.0 ? (1.0 / distance) * away : Vector3{0.0, 0.0, 1.0};
    const double weight_a = cube(a.radius), weight_b = cube(b.radius), overlap = touching - distance;
    see(other);
    is_pushed_[s] = is_pushed_[other] = true;
    a.centre = a.centre - (overlap * weight_b / (weight_a + weight_b)) * normal;
    b.centre = b.centre + (overlap * weight_a / (weight_a + weight_b)) * normal;
  }

  // Not too far from where it was, off the walls, in its compartment and in the space.
  void hold(std::size_t s) {
    Sphere& sphere = spheres_[s];
    const Vector3 moved = sphere.centre - start_[s];
    const double distance = norm(moved), farthest = kFarthestMove * sphere.radius;
    if (distance > farthest) sphere.centre = start_[s] + (farthest / distance) * moved;
    list_anew_if_far(s);

    if (near_wall_[s]) push_off_walls(s);
    const double axial = std::clamp(sphere.centre[axis_], sphere.axial_low, sphere.axial_high);
    if (axial != sphere.centre[axis_]) is_pushed_[s] = true;
    sphere.centre[axis_] = axial;
    if (near_wall_[s] && !space_.inside(sphere.centre) && space_.inside(start_[s])) sphere.centre = start_[s];
    list_anew_if_far(s);
  }

  // The deepest wall first: two triangles that share an edge push once. Three walls make a corner.
  void push_off_walls(std::size_t s) {
    Sphere& sphere = spheres_[s];
    for (int corner = 0; corner < 3; ++corner) {
      walls_.clear();
      space_.walls_near(sphere.centre, (1.0 - slack_) * sphere.radius, walls_);
      if (walls_.empty()) return;
      const NearWall& deepest = *std::min_element(
          walls_.begin(), walls_.end(), [](const NearWall& a, const NearWall& b) { return a.distance < b.distance; });
      sphere.centre = sphere.centre + (sphere.radius - deepest.distance) * deepest.normal;
      is_pushed_[s] = true;
    }
  }

  std::vector<Sphere>& spheres_;
  const FreeSpace& space_;
  std::size_t axis_;
  double slack_, skin_;
  SphereGrid grid_;                             // of the places of listing
  std::vector<Vector3> start_;                  // of this sweep
  std::vector<Vector3> listed_at_;              // when near_ was made
  std::vector<std::vector<std::size_t>> near_;  // each pair in both
  std::vector<bool> near_wall_;
  std::vector<std::size_t> active_, seen_;  // by the next sweep, by this one
  std::vector<bool> is_active_, is_seen_, is_pushed_;
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

void SphereGrid::remove(int sphere, const Vector3& centre) { std::erase(cells_[index(cell_of(centre))], sphere); }

SphereGrid::Cell SphereGrid::cell_of(const Vector3& point) const {
  long c[3];
  for (std::size_t d = 0; d < 3; ++d)
    c[d] = std::clamp(static_cast<long>(std::floor((point[d] - low_[d]) / size_)), 0L, n_[d] - 1);
  return {c[0], c[1], c[2]};
}

double largest_overlap(const std::vector<Sphere>& spheres, const FreeSpace& space) {
  if (spheres.empty()) return 0.0;
  std::vector<Sphere> copy = spheres;
  return Relaxer(copy, space, 0, 0.0).worst_overlap();
}

Relaxation relax(std::vector<Sphere>& spheres, const FreeSpace& space, int axis, double tolerance, int most_sweeps) {
  if (spheres.empty()) return {};
  Relaxer relaxer(spheres, space, axis, kSlack * tolerance);
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
  relaxer.look_at_all();
  done.overlap = relaxer.worst_overlap();
  return done;
}

}  // namespace granary::dem
