// machine: its shape, how fast it turns, and how it is divided along its axis.
#include "common/json/reader.hpp"
#include "controller/campaign/sections.hpp"
#include "dem_templates/geometry/machine.hpp"

namespace granary::campaign {
namespace {

const json::Range kCount = json::Range::between(0, 1000);

void read_length(json::Reader& reader, const char* key, double& value) {
  value = reader.quantity_or(key, value, "m", json::Range::positive());
}

void read_count(json::Reader& reader, const char* key, int& value) {
  value = static_cast<int>(reader.integer_or(key, value, kCount));
}

void read_mixer(json::Reader& reader, dem::HorizontalMixer& mixer) {
  read_length(reader, "inlet_diameter", mixer.inlet_diameter);
  read_length(reader, "outlet_diameter", mixer.outlet_diameter);
  read_length(reader, "length", mixer.length);
  read_length(reader, "shaft_diameter", mixer.shaft_diameter);
  read_length(reader, "shaft_length", mixer.shaft_length);
  read_length(reader, "impeller_diameter", mixer.impeller_diameter);
  read_count(reader, "feed_elements", mixer.feed_elements);
  read_count(reader, "shear_elements", mixer.shear_elements);
  read_count(reader, "exit_elements", mixer.exit_elements);
}

void read_bowl(json::Reader& reader, dem::Machine& machine) {
  dem::BatchBowl& bowl = machine.bowl;
  read_length(reader, "bottom_diameter", bowl.bottom_diameter);
  read_length(reader, "cylinder_height", bowl.cylinder_height);
  read_length(reader, "cover_diameter", bowl.cover_diameter);
  read_length(reader, "cover_height", bowl.cover_height);
  read_length(reader, "lid_height", bowl.lid_height);
  read_length(reader, "impeller_diameter", bowl.impeller_diameter);
  read_count(reader, "impeller_blades", bowl.impeller_blades);
  bowl.impeller_pitch = reader.quantity_or("impeller_pitch", bowl.impeller_pitch, "rad", {0.0, 1.58, false, true});
  read_length(reader, "impeller_blade_width", bowl.impeller_blade_width);
  read_length(reader, "chopper_diameter", bowl.chopper_diameter);
  read_count(reader, "chopper_blades", bowl.chopper_blades);
  read_length(reader, "chopper_clearance", bowl.chopper_clearance);
  read_length(reader, "chopper_position", bowl.chopper_position);
  machine.chopper_speed =
      reader.quantity_or("chopper_speed", machine.chopper_speed, "rad/s", json::Range::not_negative());
}

/// A setting of the other type of machine is known, but has no business here.
void refuse_others(json::Reader& reader, const std::string& type, const std::string& other,
                   const std::vector<const char*>& keys) {
  for (const char* key : keys)
    if (reader.has(key))
      reader.problem(key, "only a machine of type " + other + " has it, and this one is a " + type + ".", "Remove it.");
}

void read_dimensions(json::Reader& reader, dem::Machine& machine) {
  if (machine.type == dem::Machine::Type::cm5) {
    read_mixer(reader, machine.mixer);
    refuse_others(reader, "cm5", "batch_bowl",
                  {"bottom_diameter", "cylinder_height", "cover_diameter", "cover_height", "lid_height",
                   "impeller_blades", "impeller_pitch", "impeller_blade_width", "chopper_diameter", "chopper_blades",
                   "chopper_clearance", "chopper_position", "chopper_speed"});
  } else {
    read_bowl(reader, machine);
    refuse_others(reader, "batch_bowl", "cm5",
                  {"inlet_diameter", "outlet_diameter", "length", "shaft_diameter", "shaft_length", "feed_elements",
                   "shear_elements", "exit_elements"});
  }
}

std::optional<std::filesystem::path> read_mesh(json::Reader& reader, const char* key, const Campaign& campaign) {
  if (!reader.has(key)) return std::nullopt;
  return campaign.folder / reader.text(key);
}

}  // namespace

void read_machine(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  const json::Value* written = root.raw("machine");
  if (written == nullptr) {
    root.problem("machine", "it is missing and must be given.",
                 R"(Add for example "machine": {"type": "cm5", "impeller_speed": "2000 rpm"}.)");
    return;
  }
  json::Reader reader(*written, root.file(), problems, root.pointer("machine"));
  dem::Machine& machine = campaign.dem_case.machine;
  const std::string type = reader.choice("type", {"cm5", "batch_bowl"});
  machine.type = type == "cm5" ? dem::Machine::Type::cm5 : dem::Machine::Type::batch_bowl;
  read_dimensions(reader, machine);
  machine.impeller_speed = reader.quantity("impeller_speed", "rad/s", json::Range::positive());
  machine.refinement =
      static_cast<int>(reader.integer_or("refinement", machine.refinement, json::Range::between(1, 16)));
  machine.shell_stl = read_mesh(reader, "shell_stl", campaign);
  machine.impeller_stl = read_mesh(reader, "impeller_stl", campaign);

  pbm::Compartments& compartments = campaign.pbm_case.compartments;
  const int otherwise = machine.type == dem::Machine::Type::cm5 ? 4 : 1;
  compartments.count = static_cast<int>(reader.integer_or("compartments", otherwise, json::Range::between(1, 1024)));
  campaign.compartment_edges = dem::compartment_edges(machine, compartments.count);
  compartments.volume = dem::compartment_volume(machine, compartments.count);
  if (const double bed = reader.quantity_or("bed_volume", 0.0, "m^3", json::Range::positive()); bed > 0.0)
    compartments.volume.assign(static_cast<std::size_t>(compartments.count), bed / compartments.count);
  reader.done();
}

}  // namespace granary::campaign
