// A workflow as understood: everything a campaign is started from, in SI, defaults filled in. Plain data.
// The keys a user writes, their units and defaults: docs/workflow_format.md. What happens with it is coupling/'s.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "controller/campaign/estimation.hpp"
#include "dem_templates/case/dem_case.hpp"
#include "pbm_solver/case/pbm_case.hpp"
#include "pilot/task/spec.hpp"

namespace granary::campaign {

enum class Kind { coupled, tasks, sweep };

/// When DEM and PBM take turns, and when that ends.
struct CouplingSettings {
  enum class Mode {
    two_way,   ///< DEM and PBM in turns until steady or the process is over
    one_way,   ///< one DEM burst, then the PBM to the end with its rates
    pbm_only,  ///< the PBM alone, with kernels that need no DEM
  };
  Mode mode = Mode::two_way;
  double threshold = 0.15;  ///< a watched property moved by more than this share: the other side's turn [-]
  double steady_window =
      5.0;  ///< DEM properties within the threshold for so long of DEM time, counted across bursts: steady [s]
  double steady_tolerance = 0.05;  ///< coupled state: largest change between two whole rounds that still is steady [-]
  double significance = 3.0;       ///< a change of a count is one only beyond so many standard errors [-]
  double grace = 0.2;              ///< no verdict on a DEM burst before so much measured DEM time [s]
  int least_rounds = 3;            ///< DEM + PBM is one round; no end before so many
  int most_rounds = 50;            ///< ended as "limit" after so many
};

/// The DEM beyond its base case: how it is scaled from the PBM and what it carries back.
struct DemSettings {
  enum class CarryBack {
    orthokinetic,  ///< C_real = C_dem (d_p + d_q)^3_real / (d_p + d_q)^3_dem
    equal_speed,   ///< C_real = C_dem (d_p + d_q)^2_real / (d_p + d_q)^2_dem: same relative speeds
  };
  long particles = 2000;  ///< budget: the coarse-graining factor is chosen so that there are about so many
  std::optional<double> coarse_graining;  ///< DEM diameter / real diameter; none: chosen from the budget
  CarryBack carry_back = CarryBack::orthokinetic;
  /// Powers of the coarse graining f with which a quantity of the DEM goes while the powder stays the same: it is
  /// taken to f = `at` by them before it is carried back.
  struct CoarseGrainingLaw {
    double at = 1.0;
    double collision_rate = 0.0, collision_speed = 0.0, impact_rate = 0.0, impact_speed = 0.0;
  };
  std::optional<CoarseGrainingLaw> coarse_graining_law;  ///< none: carry_back alone
  int size_classes = 6;                                  ///< of the DEM particles, and of the tallies
  double fine_cut = 0.05;                  ///< share of the volume, the finest, that rides on the finest class [-]
  std::optional<double> largest_diameter;  ///< of a DEM particle [m]: what the machine's gaps allow; none: no bound
  std::optional<double> density;       ///< of the DEM particles [kg/m^3]; none: envelope density of the PBM's particles
  double longest_burst = 1.0;          ///< measured DEM time of one burst at most [s]; also dem_case.duration
  std::optional<double> time_step;     ///< [s]; none: the longest that is allowed for each burst's particles and speeds
  std::optional<int> tally_every;      ///< steps between two looks; none: as the contact time of each burst allows
  std::optional<double> soft_overlap;  ///< particles softened until a hit presses them in so far, over the radius;
                                       ///< none: the material's own stiffness
};

struct PbmSettings {
  double longest_burst = 10.0;  ///< process time of one burst at most [s]
  int ranks = 1;
  int threads = 1;  ///< a rank
};

struct Resources {
  enum class Backend {
    local,  ///< the cores of this machine
    slurm,  ///< the nodes of the job of Slurm that we are in
  };
  Backend backend = Backend::local;
  int nodes = 1;
  std::optional<int> cores;  ///< a node; none: all that the machine has

  // What `granary submit` asks Slurm for.
  std::string partition, account;    ///< empty: Slurm's default
  std::optional<double> walltime;    ///< of one job [s]; none: the partition's
  double stop_before = 120.0;        ///< everything is stopped so long before the job's end [s]
  int chain = 0;                     ///< so many further jobs at most go on where one was stopped by its end
  bool exclusive = true;             ///< whole nodes
  std::vector<std::string> options;  ///< further options of sbatch: "--constraint=haswell"
};

struct Outputs {
  bool report = true;  ///< write report.html at the end
};

/// What the dry run believes: seconds of one core, and how the monitors would answer.
struct CostModel {
  double dem_per_particle_step = 0.4e-6;  ///< [s]
  double dem_per_step = 0.2e-3;           ///< moving walls, tallies [s]
  double pbm_per_pair = 1.2e-8;           ///< a pair of classes in one right-hand side of one compartment [s]
  double pbm_rates_per_second = 30.0;     ///< right-hand sides in a second of process time [1/s]
  double parallel_loss = 0.1;             ///< share of a core's time lost with each doubling of ranks or threads [-]
  double dem_start = 1.0;                 ///< start of a DEM burst: process, walls, restart, resize [s]
  double pbm_start = 0.2;                 ///< [s]
  double exchange = 0.1;                  ///< what the controller does between two bursts [s]
  double dem_drift_after = 0.3;           ///< measured DEM time until its monitor would say drifted [s]
  double pbm_drift_after = 5.0;           ///< process time until its monitor would say drifted [s]
  int rounds_until_steady = 5;
};

struct Campaign;

/// Cases that differ in nothing else are repetitions of one: their figures have a mean and a scatter.
constexpr const char* kSeedSetting = "/dem/seed";

/// One case of a sweep, as it would be understood by itself.
struct SweepCase {
  std::string name;                 ///< "0001": of its folder and its task
  std::vector<json::Value> values;  ///< of the swept settings as written, null: left as it is; shape (settings)
  std::vector<std::string> places;  ///< where in the workflow each value stands, "" for null; shape (settings)
  std::shared_ptr<const Campaign> understood;  ///< pbm_case or dem_case is the whole case
};

/// Kind sweep: one solver, many cases.
struct Sweep {
  enum class Solver { dem, pbm };
  struct Setting {
    std::string pointer;  ///< "/machine/impeller_speed"
    std::string name;     ///< of its column: "impeller_speed"
  };
  Solver solver = Solver::pbm;
  std::vector<Setting> settings;
  std::vector<SweepCase> cases;
  std::optional<std::filesystem::path> reference;  ///< what others got: a CSV with the settings and figures as columns
};

struct Campaign {
  std::string name;
  Kind kind = Kind::coupled;
  std::string description;

  // kind coupled
  pbm::PbmCase pbm_case;  ///< the whole process: end_time is its duration; a burst sets start, end, restart and dem
  dem::DemCase dem_case;  ///< a burst sets population, density, coarse_graining, class edges and restart
  std::array<std::string, 2> solids{"API", "excipient"};  ///< names of the two solid components
  double feed_rate = 0.0;                                 ///< solids fed [kg/s]; 0: none
  std::vector<double> compartment_edges;                  ///< along the machine's axis [m], shape (compartments + 1)
  DemSettings dem;
  PbmSettings pbm;
  CouplingSettings coupling;
  double duration = 0.0;                 ///< end of the process clock [s]
  std::optional<Estimation> estimation;  ///< none: nothing is fitted

  // kind tasks
  std::vector<pilot::TaskSpec> tasks;

  // kind sweep
  Sweep sweep;

  Resources resources;
  Outputs outputs;
  CostModel cost_model;

  std::filesystem::path file;    ///< the workflow as given
  std::filesystem::path folder;  ///< its folder, absolute: relative paths in it start there
  json::Value document;          ///< the workflow as written, overrides applied
};

/// Reads a workflow. `overrides` are "/pointer=value" (RFC 6901; the value as JSON, else as text), applied first.
/// Errors: every problem at once, one line each: FILE: POINTER is VALUE: MESSAGE HINT (Exit::bad_input).
Result<Campaign> read_campaign(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

/// Whether every task of the campaign fits on so many nodes of so many cores: what read_campaign() asks of
/// /resources/cores where that is given, and the runner of the machine it finds itself on.
Status check_resources(const Campaign& campaign, int nodes, int cores_per_node);

/// campaign.json: the workflow as written (what a resume reads again) beside how it was understood, versions and seeds.
json::Value to_json(const Campaign& campaign);

/// Reads a campaign.json back. Errors: no campaign.json; or this version understands the workflow otherwise than the
/// one that wrote it (a run must not go on with other settings than it began with).
Result<Campaign> read_written_campaign(const std::filesystem::path& file);

}  // namespace granary::campaign
