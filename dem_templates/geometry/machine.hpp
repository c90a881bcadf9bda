// The two machines as meshes and numbers: bodies, compartments, where particles go in and out.
// Pure but for reading the user's own STL files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "dem_templates/case/dem_case.hpp"
#include "dem_templates/geometry/solids.hpp"

namespace granary::dem {

/// Turning about a line [rad/s]; positive by the right-hand rule.
struct Axle {
  Vec3 point;
  Axis axis = Axis::x;
  double speed = 0.0;
};

struct Body {
  std::string name;  ///< "shell", "impeller", "chopper": the name in tallies.jsonl and of the STL file
  Mesh mesh;
  std::optional<Axle> rotation;  ///< none: it stands still
};

/// The machine's bodies, each closed, looking outwards. `Machine::refinement` n: n times as many sides of round bodies,
/// each triangle of a blade in n^2. Errors: a user's STL that cannot be used (the only case with an error).
Result<std::vector<Body>> bodies(const Machine& machine);

/// The bodies by themselves, without any user's file.
Mesh mixer_shell(const HorizontalMixer& mixer, int refinement = 1);
Mesh mixer_impeller(const HorizontalMixer& mixer, int refinement = 1);
Mesh bowl_shell(const BatchBowl& bowl, int refinement = 1);
Mesh bowl_impeller(const BatchBowl& bowl, int refinement = 1);
Mesh bowl_chopper(const BatchBowl& bowl, int refinement = 1);
std::vector<Blade> mixer_blades(const HorizontalMixer& mixer);
std::vector<Blade> bowl_blades(const BatchBowl& bowl);
Axle bowl_chopper_rotation(const BatchBowl& bowl, double speed);

/// The round parts of the bowl's rotors: the hub around z, up to hub_top, and the chopper's shaft along x, from
/// chopper_from into the wall. [m]
struct BowlShafts {
  double hub_radius, hub_top;
  Vec3 chopper;
  double chopper_radius, chopper_from;
};
BowlShafts bowl_shafts(const BatchBowl& bowl);

/// Compartments are n slices of equal length across the machine's axis; n + 1 edges [m].
std::vector<double> compartment_edges(const Machine& machine, int n);
/// Space for the bed in each compartment: between casing and shaft, less the blades [m^3].
std::vector<double> compartment_volume(const Machine& machine, int n);

/// Speed of the blade tips, the faster of impeller and chopper [m/s].
double tip_speed(const Machine& machine);

/// Largest particle that still moves freely: 0.45 of the gap between shaft and casing, or between hub and wall of the
/// bowl [m].
double largest_particle(const Machine& machine);

Axis axis_of(const Machine& machine);
Vec3 gravity_direction(const Machine& machine);

/// The box the simulation needs: all bodies, and some room around them, where particles that left are taken out.
Box3 simulation_box(const std::vector<Body>& all);

}  // namespace granary::dem
