// materials: what the particles and the liquid are, and how particles touch.
#include "common/json/reader.hpp"
#include "controller/campaign/sections.hpp"

namespace granary::campaign {
namespace {

void read_solids(json::Reader& materials, Campaign& campaign) {
  if (!materials.has("solids")) return;
  auto solids = materials.items("solids");
  if (solids.size() != 2) {
    materials.problem("solids", "it must be a list of two solids, [{\"name\": ..., \"density\": ...}, ...].");
    return;
  }
  for (std::size_t k = 0; k < 2; ++k) {
    double& density = campaign.pbm_case.materials.solid_density[k];
    campaign.solids[k] = solids[k].text_or("name", campaign.solids[k]);
    density = solids[k].quantity_or("density", density, "kg/m^3", json::Range::positive());
    solids[k].done();
  }
}

void read_liquid(json::Reader liquid, pbm::Materials& materials) {
  materials.liquid_density = liquid.quantity_or("density", materials.liquid_density, "kg/m^3", json::Range::positive());
  materials.liquid_viscosity =
      liquid.quantity_or("viscosity", materials.liquid_viscosity, "Pa s", json::Range::positive());
  materials.saturation_factor =
      liquid.number_or("saturation_factor", materials.saturation_factor, json::Range::fraction());
  liquid.done();
}

void read_contact(json::Reader section, dem::Contact& contact) {
  contact.young_modulus = section.quantity_or("young_modulus", contact.young_modulus, "Pa", json::Range::positive());
  contact.wall_young_modulus =
      section.quantity_or("wall_young_modulus", contact.wall_young_modulus, "Pa", json::Range::positive());
  contact.poisson_ratio = section.number_or("poisson_ratio", contact.poisson_ratio, json::Range::between(0.0, 0.49));
  contact.restitution = section.number_or("restitution", contact.restitution, {0.0, 1.0, false, true});
  contact.friction = section.number_or("friction", contact.friction, json::Range::not_negative());
  contact.rolling_friction =
      section.number_or("rolling_friction", contact.rolling_friction, json::Range::not_negative());
  section.done();
}

}  // namespace

void read_materials(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  json::Reader materials = section_or_empty(root, "materials", problems);
  read_solids(materials, campaign);
  read_liquid(section_or_empty(materials, "liquid", problems), campaign.pbm_case.materials);
  read_contact(section_or_empty(materials, "contact", problems), campaign.dem_case.contact);
  materials.done();
}

}  // namespace granary::campaign
