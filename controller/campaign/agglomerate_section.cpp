// process and agglomerates of a DEM by itself, as a sweep runs it: what it begins with and how long it goes.
#include <cmath>

#include "common/json/reader.hpp"
#include "controller/campaign/sections.hpp"
#include "dem_templates/geometry/machine.hpp"
#include "dem_templates/render/automatic.hpp"

namespace granary::campaign {
namespace {

using json::Range;

dem::Bonds read_bonds(json::Reader reader) {
  dem::Bonds bonds;
  bonds.radius = reader.number_or("radius", bonds.radius, Range::positive());
  bonds.normal_stiffness = reader.quantity_or("normal_stiffness", bonds.normal_stiffness, "N/m^3", Range::positive());
  bonds.shear_stiffness_ratio =
      reader.number_or("shear_stiffness_ratio", bonds.shear_stiffness_ratio, Range::positive());
  bonds.tensile_strength = reader.quantity_or("tensile_strength", bonds.tensile_strength, "Pa", Range::positive());
  bonds.shear_strength_ratio = reader.number_or("shear_strength_ratio", bonds.shear_strength_ratio, Range::positive());
  bonds.strength_scatter = reader.number_or("strength_scatter", bonds.strength_scatter, Range::fraction());
  bonds.damping = reader.number_or("damping", bonds.damping, Range::fraction());
  bonds.gap = reader.number_or("gap", bonds.gap, Range::not_negative());
  reader.done();
  return bonds;
}

dem::Agglomerates read_agglomerates(json::Reader reader, json::Problems& problems) {
  dem::Agglomerates all;
  all.count = static_cast<int>(reader.integer_or("count", all.count, Range::between(1, 1e6)));
  all.spheres = static_cast<int>(reader.integer_or("spheres", all.spheres, Range::between(1, 1e5)));
  all.sphere_diameter = reader.quantity_or("sphere_diameter", all.sphere_diameter, "m", Range::positive());
  all.diameter = reader.quantity_or("diameter", all.diameter, "m", Range::positive());
  if (all.diameter < all.sphere_diameter) reader.problem("diameter", "it must be at least the sphere_diameter.");
  all.sample_every = reader.quantity_or("sample_every", all.sample_every, "s", Range::positive());
  all.bonds = read_bonds(section_or_empty(reader, "bonds", problems));
  reader.done();
  return all;
}

}  // namespace

void read_dem_alone(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  dem::DemCase& base = campaign.dem_case;
  if (root.raw("process") == nullptr) {
    root.problem("process", "it is missing and must be given.", R"(Add for example "process": {"duration": "2 s"}.)");
  } else {
    json::Reader process = root.section("process");
    campaign.duration = process.quantity("duration", "s", Range::positive());
    for (const char* key : {"residence_time", "initial"})
      if (process.has(key)) process.problem(key, "a DEM by itself has no such setting.", "Remove it.");
    process.done();
  }
  base.agglomerates = read_agglomerates(section_or_empty(root, "agglomerates", problems), problems);
  const dem::Agglomerates& put_in = *base.agglomerates;
  const long spheres = static_cast<long>(put_in.count) * put_in.spheres;
  base.population = {{campaign.compartment_edges.empty() ? 0.0 : campaign.compartment_edges.front(),
                      campaign.compartment_edges.empty() ? 1.0 : campaign.compartment_edges.back(),
                      {put_in.sphere_diameter},
                      {spheres}}};
  base.tally.class_edges = {0.5 * put_in.sphere_diameter, 2.0 * put_in.sphere_diameter};
  base.duration = campaign.duration > 0.0 ? campaign.duration : base.duration;
  base.feed_rate = 0.0;
  base.machine.mixer.outlet_open = false;  // what breaks must not leave
  const DemSettings& dem = campaign.dem;
  if (!problems.empty()) return;  // the rest is derived, and would be from defaults
  if (dem.soft_overlap) base.contact.young_modulus = dem::automatic_young_modulus(base, *dem.soft_overlap);
  base.time_step = dem.time_step ? *dem.time_step : dem::automatic_time_step(base);
  if (!dem.tally_every) base.tally.every = dem::automatic_tally_every(base);
}

}  // namespace granary::campaign
