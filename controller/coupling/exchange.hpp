// What one side of the coupling tells the other: DEM tallies -> rate coefficients, PBM state -> DEM particles. Pure
// functions on data; the files are read in exchange_files. Equations, laws and choices: docs/coupling.md.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "controller/coupling/summary.hpp"
#include "controller/monitor/tallies.hpp"
#include "dem_templates/case/dem_case.hpp"
#include "pbm_solver/case/pbm_case.hpp"

namespace granary::coupling {

using Matrix = std::vector<std::vector<double>>;

/// How rates measured on particles f times too large are carried to real sizes (f^3 real particles stand behind one).
/// orthokinetic: collision speed grows with size (U ~ G d): C ~ (d_p + d_q)^3, so C/f^3 and collision speed/f: each
/// particle collides as often.   equal_speed: collision speed does not depend on size: C ~ (d_p + d_q)^2, so C/f^2,
/// speeds as they are. Impact rate and impact speed stay in both: the wall sweeps the same bed.
enum class ScalingLaw { orthokinetic, equal_speed };

/// What a ladder of particle numbers has found: with the same powder in the machine a quantity of the DEM goes as
/// f^power. Each is taken to f = `at` by it, and from there to real sizes by a ScalingLaw.
struct CoarseGrainingLaw {
  double at = 1.0;
  double collision_rate = 0.0;  ///< C; orthokinetic would be 3, equal_speed 2
  double collision_speed = 0.0;
  double impact_rate = 0.0;  ///< of a particle
  double impact_speed = 0.0;
};

/// What a DEM's quantities are multiplied with to be those of real sizes.
struct Carry {
  double collision_rate = 1.0;
  double collision_speed = 1.0;
  double impact_rate = 1.0;
  double impact_speed = 1.0;
};
Carry carry_back(double coarse_graining, ScalingLaw law, const std::optional<CoarseGrainingLaw>& found);

struct RateSettings {
  double grace = 0.2;  ///< windows that begin earlier after the first window's start are left out [s]
  ScalingLaw law = ScalingLaw::orthokinetic;
  std::optional<CoarseGrainingLaw> found;  ///< none: the law alone
  double prior_collisions = 25.0;          ///< counts the fitted shape is worth against a class pair's own count
  double prior_compartment = 100.0;        ///< counts a compartment factor of 1 is worth
  std::vector<double>
      class_diameter;  ///< DEM diameters that stand for the classes [m]; empty: geometric mid of the edges
};

/// Rates at real sizes with what they rest on.
struct MeasuredRates {
  pbm::DemRates rates;
  Matrix standard_error;    ///< of rates.collision_rate, by counting [m^3/s], shape (n_classes, n_classes)
  Matrix collisions;        ///< counted, shape (n_classes, n_classes)
  Matrix exposure;          ///< sum of N_p N_q dt / V in the DEM [s/m^3], shape (n_classes, n_classes)
  double shape_rate = 0.0;  ///< a of the fitted C = a (d_p + d_q)^m at real sizes [m^(3-m)/s]
  std::vector<double> compartment_collisions;  ///< counted, shape (n_compartments)
  std::vector<double> impacts;                 ///< counted, shape (n_classes)
  double coarse_graining = 1.0;
  Carry carry;              ///< has been applied
  std::size_t windows = 0;  ///< used
  int thin_pairs = 0;       ///< pairs with fewer than 100 counts: they lean on the shape
  DemSummary summary;
};

/// Maximum likelihood rates of a DEM burst, carried to real sizes.
///
///   C_pq = N_pq / E_pq,   E_pq = sum over windows and compartments of N_p N_q dt / V_x   (p = q: N_p (N_p - 1) / 2)
///
/// pulled towards the shape a (d_p + d_q)^m (m = 3, or 2 under equal_speed) by a gamma prior worth `prior_collisions`
/// counts: (N + k) / (E + k / C_shape): smooth, so a pair that was never seen takes the shape and one seen a thousand
/// times keeps its count.
/// @param bed_volume  of each compartment of the DEM [m^3], shape (n_compartments): the volume C is per
/// Errors: no window after the grace time; no collision counted; compartments that don't match; a diverged run.
/// Source: [gantt2006], docs/coupling.md.
Result<MeasuredRates> measure_rates(const monitor::Tallies& tallies, const std::vector<double>& bed_volume,
                                    const RateSettings& settings);

/// What the PBM holds at one time: particles, liquid and gas of each class in each compartment.
struct HoldUp {
  double time = 0.0;                     ///< process time [s]
  std::vector<double> solid_1, solid_2;  ///< pivots: solid volume of each component in a particle [m^3]
  std::vector<Matrix> number;            ///< particles, shape (n_compartments, N1, N2)
  std::vector<Matrix> liquid, gas;       ///< totals of the class [m^3], shape (n_compartments, N1, N2)

  std::size_t n_compartments() const { return number.size(); }
  double volume(std::size_t x) const;  ///< of the particles in compartment x, with liquid and gas [m^3]
};

/// Where a PBM case starts: its initial classes; without any, what its feed holds up at the residence time
/// (rate * residence time / compartments in each), so that the first DEM burst has something to stir.
/// Errors: neither initial classes nor a feed with a residence time.
Result<HoldUp> starting_hold_up(const pbm::PbmCase& pbm_case);

/// d50 by volume of the full distribution, and the number of particles, of each compartment.
PbmSummary summarize(const HoldUp& hold_up);

struct PopulationSettings {
  long budget = 5000;                     ///< most DEM particles
  int size_classes = 6;                   ///< at most
  double fine_cut = 0.05;                 ///< volume share at the fine end that rides on the finest class
  double largest_diameter = 0.0;          ///< of a DEM particle, what the machine's gaps allow [m]; 0: no bound
  double previous_coarse_graining = 0.0;  ///< of the burst before; 0: none
  std::vector<double> compartment_edge;   ///< along the machine's axis [m], shape (n_compartments + 1)
  std::array<double, 2> solid_density{476.0, 476.0};  ///< [kg/m^3]
  double liquid_density = 1000.0;                     ///< [kg/m^3]
};

/// A DEM population that stands for a PBM state.
struct SampledPopulation {
  std::vector<dem::Population> compartments;  ///< DEM diameters and counts, shape (n_compartments)
  std::vector<double> class_diameter;         ///< DEM [m], ascending: RateSettings::class_diameter of the burst
  std::vector<double> class_edge;             ///< DEM [m]: the tally's classes
  double coarse_graining = 1.0;
  bool coarse_graining_changed = false;  ///< against the previous burst
  double density = 0.0;                  ///< envelope: solids and liquid over the whole volume [kg/m^3]
  long total = 0;                        ///< DEM particles
  double volume = 0.0;                   ///< of the hold-up, kept [m^3]
  double volume_error = 0.0;             ///< |DEM volume - hold-up| / hold-up, by whole particles [-]
  double unrepresented_volume = 0.0;     ///< share of the volume finer than the finest class (rides on it) [-]
  double unrepresented_number = 0.0;     ///< share of the real particles in that tail [-]
  double capped_volume = 0.0;  ///< share of the volume in particles too large for the machine, shown smaller [-]
  std::string choice;          ///< one sentence: which f and cut, and why
};

/// Particles for the DEM. Classes hold equal shares of the represented volume; a class's diameter is that of its mean
/// particle volume, so it has the right number and the right volume. One DEM particle of diameter f d stands for f^3
/// real ones of diameter d: sum count pi/6 (f d)^3 = hold-up volume, in each compartment, up to half a particle.
/// f is kept from the burst before while the count stays in [budget/2, budget], else chosen for 0.75 budget; f >= 1.
/// Under a bound on the largest particle the fine tail is cut further, then what is too large is shown at the bound.
/// Errors: nothing in any compartment; a state that is not a number, or negative; a budget too small for the largest
/// diameter.
Result<SampledPopulation> sample_population(const HoldUp& hold_up, const PopulationSettings& settings);

json::Value to_json(const MeasuredRates& measured);     ///< for the journal: f, windows, counts, errors, factors
json::Value to_json(const SampledPopulation& sampled);  ///< for the journal: f, counts, shares, choice

}  // namespace granary::coupling
