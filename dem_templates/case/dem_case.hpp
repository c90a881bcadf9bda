// One DEM burst as granary-dem runs it: all SI. Plain data, also used by the controller. File form (case.json of a
// DEM burst): docs/exchange_formats.md.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "dem_templates/case/agglomerates.hpp"

namespace granary::dem {

/// Continuous horizontal mixer with paddles in a spiral on a shaft (Loedige CoriMix CM5 and its like). Axis = x.
struct HorizontalMixer {
  double inlet_diameter = 0.120;     ///< casing at x = 0 [m]
  double outlet_diameter = 0.130;    ///< casing at x = length [m]
  double length = 0.440;             ///< casing [m]
  double shaft_diameter = 0.068;     ///< [m]
  double shaft_length = 0.370;       ///< [m]
  double impeller_diameter = 0.114;  ///< tip to tip [m]
  int feed_elements = 4;             ///< paddles under the inlet
  int shear_elements = 20;
  int exit_elements = 4;
  bool outlet_open = true;  ///< false: nothing leaves; a snapshot of the hold-up
};

/// Vertical batch bowl with a bladed impeller at the bottom and a chopper in the side wall. Axis = z.
struct BatchBowl {
  double bottom_diameter = 0.080;     ///< [m]
  double cylinder_height = 0.032;     ///< [m]
  double cover_diameter = 0.060;      ///< [m]
  double cover_height = 0.0533;       ///< [m]
  double lid_height = 0.0641;         ///< [m]
  double impeller_diameter = 0.0792;  ///< tangent circle [m]
  int impeller_blades = 3;
  double impeller_pitch = 0.7854;          ///< blade angle [rad]
  double impeller_blade_width = 0.012672;  ///< along the pitched blade: with the pitch, how high it reaches [m]
  double chopper_diameter = 0.022;         ///< cutting circle [m]
  int chopper_blades = 4;
  double chopper_clearance = 0.005;  ///< between its cutting circle and the impeller's blades, or the lid [m]
  double chopper_position = 0.028;   ///< of its blades, from the bowl's axis [m]
};

struct Machine {
  enum class Type { cm5, batch_bowl };
  Type type = Type::cm5;
  HorizontalMixer mixer;                                         ///< read if type is cm5
  BatchBowl bowl;                                                ///< read if type is batch_bowl
  double impeller_speed = 209.44;                                ///< [rad/s]
  double chopper_speed = 0.0;                                    ///< [rad/s]; batch_bowl only
  std::optional<std::filesystem::path> shell_stl, impeller_stl;  ///< the user's own meshes instead of ours [m]
  int refinement = 1;  ///< of our meshes: n times the sides of round bodies, n^2 the triangles of a blade
};

/// Contact law of LIGGGHTS' `pair gran model hertz tangential history`; particle-particle and particle-wall.
struct Contact {
  double young_modulus = 8e6;          ///< [Pa]
  double wall_young_modulus = 9.99e8;  ///< [Pa]
  double poisson_ratio = 0.2;
  double restitution = 0.4;
  double friction = 0.5;
  double rolling_friction = 0.0;  ///< 0: no rolling model
};

/// What one compartment holds: diameters of DEM particles (already coarse-grained) and how many of each.
struct Population {
  double from = 0.0, to = 0.0;   ///< along the machine's axis [m]
  std::vector<double> diameter;  ///< [m]
  std::vector<long> count;
};

struct Tally {
  double window = 0.01;             ///< a line of tallies.jsonl each [s]
  int every = 5;                    ///< steps between looks at the contacts
  std::vector<double> class_edges;  ///< DEM diameters [m], ascending, n_classes + 1
};

/// Bounds beyond which a burst has diverged.
struct Guard {
  double largest_overlap = 0.5;        ///< of a particle's radius, that only a few may exceed
  double overlapping_fraction = 0.02;  ///< share of the particles that may
  double energy_factor = 20.0;         ///< kinetic energy over that of all particles at tip speed
  double lost_fraction = 0.02;         ///< particles gone that did not leave through the outlet
};

/// Who pushes particles off the machine: our granary/wall, or LIGGGHTS' own mesh/surface, move/mesh and wall/gran.
enum class Walls { granary, stock };

struct DemCase {
  std::string name;
  Machine machine;
  Walls walls = Walls::granary;
  Contact contact;
  double density = 1000.0;                   ///< of the particles [kg/m^3]
  double coarse_graining = 1.0;              ///< DEM diameter / real diameter
  std::vector<Population> population;        ///< per compartment, in order along the axis
  std::optional<Agglomerates> agglomerates;  ///< then the population counts their spheres
  double feed_rate = 0.0;                    ///< solids fed while it runs [kg/s]; 0: none
  double feed_diameter = 0.0;                ///< of the fed particles [m]; 0: the smallest of the first compartment
  double time_step = 5e-6;                   ///< [s]
  double impact_speed = 0.0;                 ///< of the fastest contacts that were measured before [m/s]; 0: tip speed
  std::optional<double> skin;                ///< extra reach of the neighbour lists [m]; none: tried out (granary/skin)
  double settle_time = 0.05;                 ///< after a fill or a resize, before the measuring starts [s]
  double duration = 0.2;                     ///< longest measuring time of the burst [s]
  Tally tally;
  Guard guard;
  std::optional<std::filesystem::path> restart;  ///< LIGGGHTS restart file of the burst before
  long seed = 86028157;
  int ranks = 1;
  std::array<int, 3> rank_grid{0, 0, 0};  ///< ranks along x, y, z; zeros: automatic_rank_grid()
};

/// From a parsed case.json; every problem at once. `file` opens the messages.
Result<DemCase> read_case(const json::Value& document, const std::string& file);
json::Value to_json(const DemCase& dem_case);

}  // namespace granary::dem
