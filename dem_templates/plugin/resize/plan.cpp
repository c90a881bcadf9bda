#include "dem_templates/plugin/resize/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "dem_templates/plugin/resize/packing.hpp"

namespace granary::dem {
namespace {

constexpr int kTries = 200;           // random places looked at for one particle
constexpr std::uint64_t kRounds = 5;  // in which trapped particles get another place
constexpr double kShortOfEnd = 1e-6;  // a centre on an edge would be the next compartment's

double volume_of(double diameter) { return std::numbers::pi / 6.0 * diameter * diameter * diameter; }

// A random number in [0, 1) that depends on nothing but its arguments. Mixing as in splitmix64:
// G. L. Steele, D. Lea, C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014.
double random(std::uint64_t seed, std::uint64_t stream, std::uint64_t n) {
  std::uint64_t z = seed + 0x9e3779b97f4a7c15ULL * (n + 1) + 0xd1342543de82ef95ULL * (stream + 1);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1p-53;
}

// The compartment a place belongs to; the nearest one if it lies in none.
std::size_t compartment_of(const ResizePopulation& population, double axial) {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < population.compartments.size(); ++c) {
    const auto& compartment = population.compartments[c];
    const double distance = std::max({0.0, compartment.from - axial, axial - compartment.to});
    if (distance < least || (distance == least && axial >= compartment.from)) {
      nearest = c;
      least = distance;
    }
  }
  return nearest;
}

// Which ranks of `have` sorted things to keep so that `keep` remain, evenly spread.
std::vector<std::size_t> evenly(std::size_t have, std::size_t keep) {
  std::vector<std::size_t> ranks(keep);
  for (std::size_t r = 0; r < keep; ++r) ranks[r] = (2 * r + 1) * have / (2 * keep);
  return ranks;
}

struct Places {
  const FreeSpace& space;
  std::size_t axis;
  SphereGrid grid;
  std::vector<Sphere> spheres;

  void add(const Sphere& sphere) {
    grid.add(static_cast<int>(spheres.size()), sphere.centre);
    spheres.push_back(sphere);
  }

  // Overlap with what is there, over the smaller radius. Places in walls are worse than any overlap of particles.
  double overlap_at(const Vector3& centre, double radius) const {
    thread_local std::vector<NearWall> walls;
    walls.clear();
    if (!space.inside(centre)) return std::numeric_limits<double>::infinity();
    space.walls_near(centre, radius, walls);
    double worst = 0.0;
    for (const NearWall& wall : walls) worst = std::max(worst, 10.0 * (1.0 - wall.distance / radius));
    grid.around(centre, [&](int other) {
      const Sphere& sphere = spheres[static_cast<std::size_t>(other)];
      worst =
          std::max(worst, (radius + sphere.radius - norm(centre - sphere.centre)) / std::min(radius, sphere.radius));
    });
    return worst;
  }

  // A free random place, or the least overlapping one found; nothing if none lies in the space.
  bool find(Sphere& sphere, std::uint64_t seed, std::uint64_t stream) const {
    const Vector3 low = space.low(), high = space.high();
    double least = std::numeric_limits<double>::infinity();
    for (std::uint64_t n = 0; n < kTries && least > 0.0; ++n) {
      Vector3 centre;
      for (std::size_t d = 0; d < 3; ++d) {
        const double from = d == axis ? sphere.axial_low : low[d], to = d == axis ? sphere.axial_high : high[d];
        centre[d] = from + (to - from) * random(seed, stream, 3 * n + d);
      }
      const double overlap = overlap_at(centre, sphere.radius);
      if (overlap >= least) continue;
      least = overlap;
      sphere.centre = centre;
    }
    return std::isfinite(least);
  }
};

// Spheres that pushing cannot free (grown between a blade's tip and the casing, say) get another place in their
// compartment: all that overlap by more than `bound`. False if there is no place for one.
bool move_trapped(Places& places, double largest, double bound, std::uint64_t seed) {
  Places fresh{places.space, places.axis, SphereGrid(places.space.low(), places.space.high(), largest), places.spheres};
  std::vector<std::size_t> trapped;
  for (std::size_t k = 0; k < fresh.spheres.size(); ++k) {
    const Sphere& sphere = fresh.spheres[k];
    if (fresh.overlap_at(sphere.centre, sphere.radius) > bound) {
      trapped.push_back(k);
    } else {
      fresh.grid.add(static_cast<int>(k), sphere.centre);
    }
  }
  for (const std::size_t k : trapped) {
    if (!fresh.find(fresh.spheres[k], seed, k)) return false;
    fresh.grid.add(static_cast<int>(k), fresh.spheres[k].centre);
  }
  places.spheres = std::move(fresh.spheres);
  return true;
}

Error does_not_fit(const ResizePopulation& population, std::size_t c, const std::string& why) {
  const auto& compartment = population.compartments[c];
  return Error{
      fmt::format("resize: {} particles of together {:.4g} m^3 do not fit between {:.4g} m and {:.4g} m: {}. Ask for "
                  "less hold-up there, "
                  "or allow more sweeps or a larger overlap. See docs/dem_styles.md.",
                  compartment.diameters.size(), compartment.volume(), compartment.from, compartment.to, why)};
}

// The compartment with the largest overlaps of its own.
std::size_t worst_compartment(const ResizePopulation& population, const std::vector<Sphere>& spheres,
                              const FreeSpace& space, std::size_t axis) {
  std::size_t worst = 0;
  double most = -1.0;
  for (std::size_t c = 0; c < population.compartments.size(); ++c) {
    std::vector<Sphere> own;
    for (const Sphere& sphere : spheres)
      if (compartment_of(population, sphere.centre[axis]) == c) own.push_back(sphere);
    const double overlap = largest_overlap(own, space);
    if (overlap > most) worst = c, most = overlap;
  }
  return worst;
}

}  // namespace

Result<ResizePlan> plan_resize(std::vector<Particle> existing, const ResizePopulation& population,
                               const FreeSpace& space, const ResizeOptions& options) {
  const auto axis = static_cast<std::size_t>(options.axis);
  const std::size_t n_compartments = population.compartments.size();
  ResizePlan plan;
  plan.compartments.resize(n_compartments);

  std::sort(existing.begin(), existing.end(), [](const Particle& a, const Particle& b) { return a.tag < b.tag; });
  std::int64_t next_tag = existing.empty() ? 1 : existing.back().tag + 1;
  double largest = population.largest_diameter();
  std::vector<Sphere> before;
  std::vector<std::vector<Particle>> present(n_compartments);
  for (const Particle& particle : existing) {
    largest = std::max(largest, particle.diameter);
    before.push_back({particle.centre, 0.5 * particle.diameter});
    present[compartment_of(population, particle.centre[axis])].push_back(particle);
  }
  plan.overlap_before = largest_overlap(before, space);

  // Sizes: rank by rank.
  std::vector<std::vector<double>> missing(n_compartments);
  std::vector<std::size_t> home;  // compartment of each kept particle
  for (std::size_t c = 0; c < n_compartments; ++c) {
    auto& particles = present[c];
    const auto& wanted = population.compartments[c].diameters;
    auto& count = plan.compartments[c];
    count.before = particles.size();
    for (const Particle& particle : particles) count.volume_before += volume_of(particle.diameter);
    count.volume = population.compartments[c].volume();

    std::stable_sort(particles.begin(), particles.end(),
                     [](const Particle& a, const Particle& b) { return a.diameter < b.diameter; });
    const std::size_t n_kept = std::min(particles.size(), wanted.size());
    const auto keep = evenly(particles.size(), n_kept), fill = evenly(wanted.size(), n_kept);
    std::vector<bool> stays(particles.size(), false), filled(wanted.size(), false);
    for (std::size_t r = 0; r < n_kept; ++r) {
      Particle particle = particles[keep[r]];
      particle.diameter = wanted[fill[r]];
      stays[keep[r]] = filled[fill[r]] = true;
      plan.kept.push_back(particle);
      home.push_back(c);
    }
    for (std::size_t r = 0; r < particles.size(); ++r)
      if (!stays[r]) plan.removed.push_back(particles[r].tag);
    for (std::size_t r = wanted.size(); r-- > 0;)
      if (!filled[r]) missing[c].push_back(wanted[r]);  // the largest first: they find a place least easily
    count.kept = n_kept;
    count.removed = particles.size() - n_kept;
    count.inserted = missing[c].size();
  }

  // Places.
  Places places{space, axis, SphereGrid(space.low(), space.high(), largest), {}};
  const auto sphere_in = [&](std::size_t c, const Vector3& centre, double diameter) {
    const auto& compartment = population.compartments[c];
    const double short_of_end = kShortOfEnd * (compartment.to - compartment.from);
    return Sphere{centre, 0.5 * diameter, compartment.from, compartment.to - short_of_end};
  };
  for (std::size_t k = 0; k < plan.kept.size(); ++k)
    places.add(sphere_in(home[k], plan.kept[k].centre, plan.kept[k].diameter));
  for (std::size_t c = 0; c < n_compartments; ++c) {
    for (double diameter : missing[c]) {
      Sphere sphere = sphere_in(c, {}, diameter);
      if (!places.find(sphere, options.seed, static_cast<std::uint64_t>(next_tag)))
        return does_not_fit(population, c, fmt::format("no place for a particle of {:.4g} m was found", diameter));
      places.add(sphere);
      plan.inserted.push_back({next_tag++, sphere.centre, diameter});
    }
  }
  plan.overlap_resized = largest_overlap(places.spheres, space);

  Relaxation relaxed = relax(places.spheres, space, options.axis, options.overlap, options.sweeps);
  const double bound = kHopeless * options.overlap;
  for (std::uint64_t round = 1; relaxed.overlap > bound && round <= kRounds; ++round) {
    if (!move_trapped(places, largest, bound, options.seed + round)) break;
    const int sweeps = relaxed.sweeps;
    relaxed = relax(places.spheres, space, options.axis, options.overlap, options.sweeps);
    relaxed.sweeps += sweeps;
  }
  plan.overlap = relaxed.overlap;
  plan.sweeps = relaxed.sweeps;
  if (relaxed.overlap > bound)
    return does_not_fit(
        population, worst_compartment(population, places.spheres, space, axis),
        fmt::format("overlaps of {:.3g} of the radius are left after {} sweeps", relaxed.overlap, relaxed.sweeps));
  for (std::size_t k = 0; k < plan.kept.size(); ++k) plan.kept[k].centre = places.spheres[k].centre;
  for (std::size_t k = 0; k < plan.inserted.size(); ++k)
    plan.inserted[k].centre = places.spheres[plan.kept.size() + k].centre;
  std::sort(plan.kept.begin(), plan.kept.end(), [](const Particle& a, const Particle& b) { return a.tag < b.tag; });
  return plan;
}

std::string describe(const ResizePlan& plan, const ResizePopulation& population) {
  std::string text = "resize:";
  for (std::size_t c = 0; c < plan.compartments.size(); ++c) {
    const auto& count = plan.compartments[c];
    text += fmt::format(
        " [{:.4g}, {:.4g}] m: {} -> {} particles (asked {}; {} kept, {} new, {} removed), {:.6g} -> {:.6g} m^3 (asked "
        "{:.6g});",
        population.compartments[c].from, population.compartments[c].to, count.before, count.kept + count.inserted,
        population.compartments[c].diameters.size(), count.kept, count.inserted, count.removed, count.volume_before,
        count.volume, population.compartments[c].volume());
  }
  return text + fmt::format(" largest overlap {:.3g} -> {:.3g} resized -> {:.3g} after {} sweeps", plan.overlap_before,
                            plan.overlap_resized, plan.overlap, plan.sweeps);
}

}  // namespace granary::dem
