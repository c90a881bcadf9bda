// process and agglomerates of a DEM by itself, as a sweep runs it: what it begins with and how long it goes.
#include "common/json/reader.hpp"
#include "controller/campaign/sections.hpp"
#include "dem_templates/geometry/machine.hpp"
#include "dem_templates/render/automatic.hpp"

namespace granary::campaign {

void read_dem_alone(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  dem::DemCase& base = campaign.dem_case;
  if (root.raw("process") == nullptr) {
    root.problem("process", "it is missing and must be given.", R"(Add for example "process": {"duration": "2 s"}.)");
  } else {
    json::Reader process = root.section("process");
    campaign.duration = process.quantity("duration", "s", json::Range::positive());
    for (const char* key : {"residence_time", "initial"})
      if (process.has(key)) process.problem(key, "a DEM by itself has no such setting.", "Remove it.");
    process.done();
  }
  base.agglomerates =
      dem::read_agglomerates(section_or_empty(root, "agglomerates", problems), dem::Written::with_units);
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
