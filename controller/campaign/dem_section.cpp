// dem: how many particles stand for the powder, how they are stepped and watched.
#include "common/json/reader.hpp"
#include "controller/campaign/sections.hpp"

namespace granary::campaign {
namespace {

using json::Range;

constexpr double kSoftOverlap = 0.3;

bool is_prime(std::int64_t n) {
  for (std::int64_t d = 2; d * d <= n; ++d)
    if (n % d == 0) return false;
  return n > 1;
}

void read_guard(json::Reader reader, dem::Guard& guard) {
  guard.largest_overlap = reader.number_or("largest_overlap", guard.largest_overlap, {0.0, 1.0, false, true});
  guard.overlapping_fraction = reader.number_or("overlapping_fraction", guard.overlapping_fraction, Range::fraction());
  guard.energy_factor = reader.number_or("energy_factor", guard.energy_factor, Range::positive());
  guard.lost_fraction = reader.number_or("lost_fraction", guard.lost_fraction, Range::fraction());
  reader.done();
}

void read_seed(json::Reader& reader, long& seed) {
  seed = reader.integer_or("seed", seed, Range::between(1, kLargestSeed));
  if (const std::int64_t next = next_seed(seed); next != seed)
    reader.problem("seed", "it must be a prime number above 10000.", "The next one is " + std::to_string(next) + ".");
}

void read_rank_grid(json::Reader& reader, dem::DemCase& base) {
  if (is_auto(reader, "rank_grid")) return;
  const auto grid = reader.numbers("rank_grid", Range::at_least(1));
  double product = 1.0;
  for (std::size_t d = 0; d < std::min<std::size_t>(grid.size(), 3); ++d) {
    base.rank_grid[d] = static_cast<int>(grid[d]);
    product *= base.rank_grid[d];
  }
  if (grid.size() != 3 || product != base.ranks)
    reader.problem("rank_grid",
                   "it must be three whole numbers whose product is /dem/ranks, " + std::to_string(base.ranks) + ".");
}

void read_coarse_graining_law(json::Reader& reader, DemSettings& dem) {
  std::optional<json::Reader> section = reader.optional_section("coarse_graining_law");
  if (!section) return;
  const Range power = Range::between(-6, 6);
  DemSettings::CoarseGrainingLaw law;
  law.at = section->number("at", Range::at_least(1.0));
  law.collision_rate = section->number("collision_rate", power);
  law.collision_speed = section->number("collision_speed", power);
  law.impact_rate = section->number("impact_rate", power);
  law.impact_speed = section->number("impact_speed", power);
  section->done();
  dem.coarse_graining_law = law;
}

void read_scaling(json::Reader& reader, DemSettings& dem) {
  dem.particles = reader.integer_or("particles", dem.particles, Range::at_least(1));
  if (!is_auto(reader, "coarse_graining")) {
    const json::Value* written = reader.raw("coarse_graining");
    if (written->is_number())
      dem.coarse_graining = reader.number_or("coarse_graining", 1.0, Range::at_least(1.0));
    else
      reader.problem("coarse_graining", "it must be \"auto\" or a number >= 1.");
  }
  if (!is_auto(reader, "particle_density"))
    dem.density = reader.quantity_or("particle_density", 1000.0, "kg/m^3", Range::positive());
  const std::string law = reader.choice_or("carry_back", "orthokinetic", {"orthokinetic", "equal_speed"});
  dem.carry_back = law == "orthokinetic" ? DemSettings::CarryBack::orthokinetic : DemSettings::CarryBack::equal_speed;
  read_coarse_graining_law(reader, dem);
  dem.size_classes = static_cast<int>(reader.integer_or("size_classes", dem.size_classes, Range::between(1, 64)));
  dem.fine_cut = reader.number_or("fine_cut", dem.fine_cut, {0.0, 1.0, true, false});
  if (!is_auto(reader, "largest_diameter"))
    dem.largest_diameter = reader.quantity_or("largest_diameter", 0.0, "m", Range::positive());
}

}  // namespace

std::int64_t next_seed(std::int64_t from) {
  std::int64_t next = std::max<std::int64_t>(from, 10001);
  while (!is_prime(next)) ++next;
  return next;
}

void read_dem(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  json::Reader reader = section_or_empty(root, "dem", problems);
  DemSettings& dem = campaign.dem;
  dem::DemCase& base = campaign.dem_case;
  read_scaling(reader, dem);
  base.coarse_graining = dem.coarse_graining.value_or(base.coarse_graining);
  base.density = dem.density.value_or(base.density);

  base.walls =
      reader.choice_or("walls", "granary", {"granary", "stock"}) == "granary" ? dem::Walls::granary : dem::Walls::stock;
  if (!is_auto(reader, "time_step")) dem.time_step = reader.quantity_or("time_step", 0.0, "s", Range::positive());
  if (reader.choice_or("stiffness", "material", {"material", "auto"}) == "auto") dem.soft_overlap = kSoftOverlap;
  const double overlap = reader.number_or("impact_overlap", kSoftOverlap, {0.0, 1.0, false, true});
  if (dem.soft_overlap) dem.soft_overlap = overlap;
  if (!is_auto(reader, "skin")) base.skin = reader.quantity_or("skin", 0.0, "m", Range::positive());
  base.settle_time = reader.quantity_or("settle", base.settle_time, "s", Range::not_negative());
  base.tally.window = reader.quantity_or("tally_window", base.tally.window, "s", Range::positive());
  if (!is_auto(reader, "tally_every")) {
    dem.tally_every = static_cast<int>(reader.integer_or("tally_every", 1, Range::between(1, 10000)));
    base.tally.every = *dem.tally_every;
  }
  dem.longest_burst = reader.quantity_or("longest_burst", dem.longest_burst, "s", Range::positive());
  base.duration = dem.longest_burst;
  base.machine.mixer.outlet_open = reader.boolean_or("through_flow", true);
  if (base.machine.mixer.outlet_open) base.feed_rate = campaign.feed_rate;
  read_guard(section_or_empty(reader, "guard", problems), base.guard);
  read_seed(reader, base.seed);
  base.ranks = static_cast<int>(reader.integer_or("ranks", base.ranks, Range::between(1, 100000)));
  read_rank_grid(reader, base);
  reader.done();
}

}  // namespace granary::campaign
