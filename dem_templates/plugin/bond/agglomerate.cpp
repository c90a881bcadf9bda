#include "dem_templates/plugin/bond/agglomerate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "common/json/io.hpp"
#include "dem_templates/plugin/bond/strength.hpp"
#include "dem_templates/plugin/resize/packing.hpp"
#include "dem_templates/plugin/wall/vectors.hpp"

namespace granary::dem {
namespace {

constexpr const char* kFormat = "granary-agglomerates-1";

Vector3 mean_of(const Agglomerate& agglomerate) {
  Vector3 sum{};
  for (const AgglomerateSphere& sphere : agglomerate) sum = sum + sphere.centre;
  return (1.0 / static_cast<double>(agglomerate.size())) * sum;
}

// A point of a ball of radius 1 about the origin, by rejection.
Vector3 point_in_ball(std::uint64_t seed, std::uint64_t stream, std::uint64_t& n) {
  for (;;) {
    Vector3 p{};
    for (double& x : p) x = 2.0 * uniform_random(seed, stream, n++) - 1.0;
    if (dot(p, p) <= 1.0) return p;
  }
}

// Pushes centres apart to distance 1 within a ball of this radius; whether that succeeded.
bool push_apart(std::vector<Vector3>& centres, double reach) {
  constexpr int kSweeps = 3000, kPatience = 200;            // sweeps without a gain: it is jammed
  constexpr double kGoal = 1.0 + 1e-6, kDone = 1.0 + 1e-9;  // a little more than asked for, so that it ends
  double least = std::numeric_limits<double>::infinity();
  int gained = 0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double overlaps = 0.0;
    for (std::size_t a = 1; a < centres.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        const Vector3 away = centres[a] - centres[b];
        const double distance2 = dot(away, away);
        if (distance2 >= kDone * kDone) continue;
        const double distance = std::sqrt(distance2), push = 0.5 * (kGoal - distance);
        const Vector3 unit = distance > 0.0 ? (1.0 / distance) * away : Vector3{1, 0, 0};
        overlaps += push;
        centres[a] = centres[a] + push * unit;
        centres[b] = centres[b] - push * unit;
      }
    }
    if (overlaps == 0.0) return true;
    if (overlaps < 0.99 * least) {
      least = overlaps;
      gained = sweep;
    } else if (sweep - gained > kPatience) {
      return false;
    }
    for (Vector3& centre : centres)
      if (const double far = norm(centre); far > reach) centre = (reach / far) * centre;
  }
  return false;
}

// Uniform over all orientations: K. Shoemake, in Graphics Gems III (1992), 124.
Turn random_turn(std::uint64_t seed, std::uint64_t stream, std::uint64_t& n) {
  const double u = uniform_random(seed, stream, n++), a = 2.0 * std::numbers::pi * uniform_random(seed, stream, n++),
               b = 2.0 * std::numbers::pi * uniform_random(seed, stream, n++);
  const double x = std::sqrt(1.0 - u) * std::sin(a), y = std::sqrt(1.0 - u) * std::cos(a),
               z = std::sqrt(u) * std::sin(b), w = std::sqrt(u) * std::cos(b);
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
           {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
           {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}}};
}

class Placer {
 public:
  Placer(const FreeSpace& space, const Agglomerate& there, double largest)
      : space_(space), grid_(space.low(), space.high(), 2.0 * largest) {
    for (const AgglomerateSphere& sphere : there) add(sphere);
  }
  void add(const AgglomerateSphere& sphere) {
    grid_.add(static_cast<int>(spheres_.size()), sphere.centre);
    spheres_.push_back(sphere);
  }
  bool is_free(const AgglomerateSphere& sphere) {
    if (!space_.inside(sphere.centre)) return false;
    walls_.clear();
    space_.walls_near(sphere.centre, sphere.radius, walls_);
    if (!walls_.empty()) return false;
    bool free = true;
    grid_.around(sphere.centre, [&](int k) {
      const AgglomerateSphere& other = spheres_[static_cast<std::size_t>(k)];
      const Vector3 away = other.centre - sphere.centre;
      const double touching = other.radius + sphere.radius;
      free = free && dot(away, away) >= touching * touching;
    });
    return free;
  }

 private:
  const FreeSpace& space_;
  SphereGrid grid_;
  Agglomerate spheres_;
  std::vector<NearWall> walls_;
};

Result<Agglomerate> read_one(const json::Value& item, const std::string& place) {
  Agglomerate agglomerate;
  for (const json::Value& row : item["spheres_m"].items_or_none()) {
    const std::vector<double> numbers = row.is_array() ? row.numbers() : std::vector<double>{};
    const bool good = numbers.size() == 4 && numbers[3] > 0.0 &&
                      std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
    if (!good)
      return Error{place + "/spheres_m/" + std::to_string(agglomerate.size()) +
                   " must be [x, y, z, radius] in metres, the radius > 0. See docs/dem_styles.md."};
    agglomerate.push_back({{numbers[0], numbers[1], numbers[2]}, numbers[3]});
  }
  if (agglomerate.empty()) return Error{place + "/spheres_m must list at least one sphere. See docs/dem_styles.md."};
  return agglomerate;
}

}  // namespace

double agglomerate_diameter(const Agglomerate& agglomerate) {
  if (agglomerate.empty()) return 0.0;
  const Vector3 mean = mean_of(agglomerate);
  double farthest = 0.0;
  for (const AgglomerateSphere& sphere : agglomerate)
    farthest = std::max(farthest, norm(sphere.centre - mean) + sphere.radius);
  return 2.0 * farthest;
}

double solid_fraction(const Agglomerate& agglomerate) {
  double cubes = 0.0;
  for (const AgglomerateSphere& sphere : agglomerate) cubes += std::pow(2.0 * sphere.radius, 3);
  return agglomerate.empty() ? 0.0 : cubes / std::pow(agglomerate_diameter(agglomerate), 3);
}

Agglomerate pack_ball(int n, double sphere_diameter, double ball_diameter, std::uint64_t seed) {
  constexpr std::uint64_t kStarts = 20;
  constexpr double kGrowth = 1.005;
  constexpr double kDensest = 0.7;  // no ball of up to 1000 equal spheres is known to be fuller
  const double least = n > 1 ? std::max(2.0, std::cbrt(n / kDensest)) : 1.0;
  double reach = 0.5 * (std::max(least, ball_diameter / sphere_diameter) - 1.0);  // of the centres, in sphere diameters
  for (std::uint64_t start = 0;; ++start) {
    if (start > 0 && start % kStarts == 0) reach *= kGrowth;
    std::uint64_t number = 0;
    std::vector<Vector3> centres(static_cast<std::size_t>(n));
    for (Vector3& centre : centres) centre = reach * point_in_ball(seed, start, number);
    if (!push_apart(centres, reach)) continue;
    Agglomerate packed;
    for (const Vector3& centre : centres) packed.push_back({sphere_diameter * centre, 0.5 * sphere_diameter});
    return packed;
  }
}

Result<std::vector<Agglomerate>> read_agglomerates(const std::filesystem::path& file) {
  GRANARY_TRY(const json::Value document, json::read_file(file));
  if (document.text_or("format", "") != kFormat)
    return Error{file.string() + ": /format must be \"" + kFormat + "\". See docs/dem_styles.md."};
  std::vector<Agglomerate> agglomerates;
  for (const json::Value& item : document["agglomerates"].items_or_none()) {
    GRANARY_TRY(Agglomerate one,
                read_one(item, file.string() + ": /agglomerates/" + std::to_string(agglomerates.size())));
    agglomerates.push_back(std::move(one));
  }
  if (agglomerates.empty())
    return Error{file.string() + ": /agglomerates must list at least one agglomerate. See docs/dem_styles.md."};
  return agglomerates;
}

Status write_agglomerates(const std::filesystem::path& file, const std::vector<Agglomerate>& agglomerates) {
  json::Array items;
  for (const Agglomerate& agglomerate : agglomerates) {
    json::Array rows;
    for (const auto& [centre, radius] : agglomerate)
      rows.emplace_back(std::vector<double>{centre[0], centre[1], centre[2], radius});
    items.push_back(json::Value::object({{"spheres_m", std::move(rows)}}));
  }
  return json::write_file(file, json::Value::object({{"format", kFormat}, {"agglomerates", std::move(items)}}));
}

Result<std::vector<Agglomerate>> place_agglomerates(const std::vector<Agglomerate>& shapes, const FreeSpace& space,
                                                    const Agglomerate& there, const Placing& placing) {
  double largest = 0.0;
  for (const AgglomerateSphere& sphere : there) largest = std::max(largest, sphere.radius);
  for (const Agglomerate& shape : shapes)
    for (const AgglomerateSphere& sphere : shape) largest = std::max(largest, sphere.radius);

  Placer placer(space, there, largest);
  std::vector<Agglomerate> placed;
  const Vector3 low = space.low(), size = space.high() - low;
  for (int k = 0; k < placing.count; ++k) {
    const Agglomerate& shape = shapes[static_cast<std::size_t>(k) % shapes.size()];
    const Vector3 mean = mean_of(shape);
    std::optional<Agglomerate> found;
    std::uint64_t number = 0;
    for (int t = 0; t < placing.tries && !found; ++t) {
      Vector3 place{};
      for (std::size_t d = 0; d < 3; ++d)
        place[d] = low[d] + size[d] * uniform_random(placing.seed, static_cast<std::uint64_t>(k), number++);
      const Turn turn = random_turn(placing.seed, static_cast<std::uint64_t>(k), number);
      Agglomerate candidate;
      for (const auto& [centre, radius] : shape) {
        candidate.push_back({place + turn.to_lab(centre - mean), radius});
        if (!placer.is_free(candidate.back())) break;
      }
      if (candidate.size() == shape.size() && placer.is_free(candidate.back())) found = std::move(candidate);
    }
    if (!found)
      return Error{
          fmt::format("there is room for {} of the {} agglomerates only: {} random places were tried for the "
                      "next one. Ask for fewer, give a larger region or another seed.",
                      k, placing.count, placing.tries)};
    for (const AgglomerateSphere& sphere : *found) placer.add(sphere);
    placed.push_back(std::move(*found));
  }
  return placed;
}

}  // namespace granary::dem
