// One population balance as granary-pbm runs it: all SI, all defaults filled in. Plain data, also used by the
// controller. The file form (case.json) and each member's meaning and unit: docs/exchange_formats.md. Equations:
// docs/pbm_equations.md.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::pbm {

/// Pivots s_k,i = smallest_k * ratio_k^(i-1): solid volume of component k in a particle [m^3]. Component 0 is the API,
/// 1 the excipient.
struct Grid {
  std::array<int, 2> bins{16, 16};
  std::array<double, 2> smallest{5e-16, 5e-16};  ///< [m^3]
  std::array<double, 2> ratio{3.0, 3.0};         ///< > 1
};

/// Compartments in a row along the axis; outflow of each into the next (the last: the outlet) at rate k = count /
/// residence_time.
struct Compartments {
  int count = 1;
  std::vector<double> volume;            ///< bed (geometric) volume of each [m^3], shape (count)
  std::optional<double> residence_time;  ///< of the whole row [s]; none: no flow at all (batch)
};

struct Materials {
  std::array<double, 2> solid_density{476.0, 476.0};  ///< [kg/m^3]
  double liquid_density = 1000.0;                     ///< [kg/m^3]
  double liquid_viscosity = 0.05;                     ///< [Pa s]
  double saturation_factor = 0.0;                     ///< phi: l_int = min(phi g, l) [-]
};

struct ClassRate {
  int i = 0, j = 0;   ///< class indices from 0
  double rate = 0.0;  ///< feed: particles/s; initial state: particles
};

struct Feed {
  std::vector<ClassRate> classes;
  double porosity = 0.0;  ///< of the fed particles: gas = solid porosity/(1-porosity)
  double start = 0.0;     ///< [s] process time
  double end = 1e300;     ///< [s]
};

struct Spray {
  double rate = 0.0;    ///< liquid volume per time [m^3/s]
  int compartment = 0;  ///< from 0
  double start = 0.0;   ///< [s]
  double end = 1e300;   ///< [s]
};

/// Log-normal distribution of speeds: mean and standard deviation of ln U, U in m/s.
struct SpeedDistribution {
  double ln_mean = 0.0;
  double ln_sigma = 1.0;
};

/// What the DEM says, already carried to real sizes: rate coefficients per volume between size classes.
struct DemRates {
  std::vector<double> diameter;                     ///< class centres [m], ascending, shape (n_classes)
  std::vector<std::vector<double>> collision_rate;  ///< C_pq [m^3/s], symmetric, shape (n_classes, n_classes)
  std::vector<double> compartment_factor;  ///< multiplies C and the impact rate in each compartment, shape (count)
  std::vector<double> impact_rate;    ///< impacts per particle and time with walls and blades [1/s], shape (n_classes)
  SpeedDistribution collision_speed;  ///< relative normal speed at first touch
  SpeedDistribution impact_speed;
};

struct Efficiency {
  enum class Model { constant, wet, stokes };
  Model model = Model::constant;
  double value = 1.0;                  ///< constant: psi; wet: psi where both are wet
  double least_liquid_fraction = 0.2;  ///< wet: l_ext/V of each partner at least
  double restitution = 0.2;            ///< stokes: e
  double asperity = 5e-6;              ///< stokes: h_a [m]
};

/// A user's rate coefficients between diameters, bilinear in ln d between them, constant beyond them.
struct KernelTable {
  std::vector<double> diameter;           ///< [m], ascending, shape (n)
  std::vector<std::vector<double>> rate;  ///< C_pq [m^3/s], symmetric, shape (n, n)
};

/// beta = rate * C * psi / V_compartment. constant: C = 1 m^3/s; sum: C = v + v' in units of reference_volume; product
/// likewise; shear: C = (d + d')^3; dem: DemRates; table: KernelTable.
struct Aggregation {
  enum class Kernel { constant, sum, product, shear, dem, table };
  /// dem and table. size: interpolated at the particles' diameters; group: constant within each size class, which a PBM
  /// class belongs to by its dry volume at the feed's porosity (faster: no pair is looked at).
  enum class Lookup { size, group };
  /// How births are summed: chosen by the solver, every pair, or products of a low-rank form.
  enum class Method { automatic, pairs, low_rank };
  Kernel kernel = Kernel::constant;
  double rate = 1.0;  ///< beta_0
  KernelTable table;
  Lookup lookup = Lookup::size;
  Method method = Method::automatic;
  Efficiency efficiency;
};

/// Breakage as it was measured, by the solid volume of the parent.
struct BreakageTable {
  struct Daughter {
    double share = 0.0;   ///< of the parent's volume, in (0, 1)
    double number = 0.0;  ///< so many of them a break, on average
  };
  std::vector<double> solid;                     ///< of the parents [m^3], ascending, shape (n)
  std::vector<double> rate;                      ///< [1/s], shape (n)
  std::vector<std::vector<Daughter>> daughters;  ///< of each parent: sum number share = 1, shape (n)
};

/// K_br = rate * C_imp * P(U > U_br). constant: C_imp P = 1/s; linear: C_imp P = v / reference_volume; power: its
/// `exponent`-th power (both for exact solutions); impact: DEM; table: C_imp P linear in ln v between the table's
/// parents, constant beyond them.
struct Breakage {
  enum class Selection { constant, linear, power, impact, table };
  enum class Daughters { uniform_binary, halves, same_composition, table };
  Selection selection = Selection::impact;
  Daughters daughters = Daughters::uniform_binary;
  BreakageTable table;                       ///< where selection or daughters are of it
  double rate = 1.0;                         ///< k_br [-]
  double exponent = 1.0;                     ///< power: of the solid volume [-]
  double critical_stokes_deformation = 0.2;  ///< St*_def
  double primary_diameter = 12.4e-6;         ///< d_pp [m]
};

struct Consolidation {
  double rate = 0.0;            ///< c nu^omega [1/s]
  double least_porosity = 0.2;  ///< eps_min
};

/// Where a run starts: empty, given classes (every compartment alike unless `compartment` >= 0), or a state of an
/// earlier run.
struct InitialClass {
  int compartment = -1;
  int i = 0, j = 0;
  double number = 0.0;  ///< particles in that compartment
  double liquid = 0.0;  ///< total liquid of these particles [m^3]
  double gas = 0.0;     ///< total gas of these particles [m^3]
};

struct Restart {
  std::filesystem::path file;  ///< out.h5 or checkpoint.h5 of an earlier run
  std::optional<double> time;  ///< the state at this output time; none: the last
};

struct PbmCase {
  std::string name;
  Grid grid;
  Compartments compartments;
  Materials materials;
  std::optional<Feed> feed;
  std::optional<Spray> spray;
  std::optional<DemRates> dem;
  std::optional<Aggregation> aggregation;
  std::optional<Breakage> breakage;
  std::optional<Consolidation> consolidation;
  std::vector<InitialClass> initial;
  std::optional<Restart> restart;
  double start_time = 0.0;           ///< [s]; with a restart: the restart's time is used
  double end_time = 1.0;             ///< [s]
  double output_every = 0.2;         ///< [s] of process time: progress line, state in the output file
  double relative_tolerance = 1e-3;  ///< local error of a step, volume-weighted
  /// Kernels and selection functions that look at liquid and porosity are re-used until volume or film of a particle
  /// has moved by this share; low-rank forms are as near to the kernel as this share of the collision rate. 0: never
  /// re-used, never approximate.
  double kernel_tolerance = 1e-3;
  double reference_volume = 1.0;  ///< [m^3]: unit of v in the sum, product and linear rates
};

/// From a parsed case.json; every problem at once. `file` opens the messages.
Result<PbmCase> read_case(const json::Value& document, const std::string& file);
json::Value to_json(const PbmCase& pbm_case);

/// The member "table" of a kernel file (format "granary-breakage-kernel-1", docs/exchange_formats.md), with daughters.
Result<BreakageTable> read_breakage_table(const json::Value& document, const std::string& file);
json::Value to_json(const BreakageTable& table);

}  // namespace granary::pbm
