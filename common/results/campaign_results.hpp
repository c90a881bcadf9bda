// Everything a user would plot of one campaign, as plain data, and its file results.h5.
// Names, shapes and units of the datasets: common/results/schema.hpp; for readers of the file: docs/results_format.md.
// Drawing them is controller/report's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "common/results/estimation_summary.hpp"

namespace granary {

using Rows = std::vector<std::vector<double>>;  ///< one row a time, burst or class; all rows equally long
using Tables = std::vector<Rows>;               ///< one table a snapshot; all equally large

/// Who ran what, where and from which settings.
struct Provenance {
  struct Version {
    std::string of;     ///< "granary", "liggghts", "openmpi", "hdf5", ...
    std::string value;  ///< "0.1.0 (f12029e)"
    bool operator==(const Version&) const = default;
  };
  struct Seed {
    std::string of;  ///< what it seeds: "dem burst 1 attempt 1"
    std::int64_t value = 0;
    bool operator==(const Seed&) const = default;
  };

  std::string name;      ///< of the campaign
  std::string kind;      ///< coupled | tasks | sweep
  std::string version;   ///< of Granary
  std::string revision;  ///< the commit it was built from
  std::vector<Version> versions;
  std::vector<Seed> seeds;
  std::string host;           ///< "node7: 2 cores of AMD EPYC 7B13, 8 GB"
  std::string started;        ///< ISO 8601, UTC: "2026-11-22T03:00:00Z"
  std::string finished;       ///< likewise
  std::string campaign_json;  ///< the text of campaign.json
  bool operator==(const Provenance&) const = default;
};

/// One stretch of DEM or PBM between two switches. NaN where a number does not exist for that kind of burst.
struct BurstSummary {
  std::int64_t number = 0;     ///< from 1, as in bursts/0001-dem
  std::string kind;            ///< dem | pbm
  std::string reason;          ///< why it ended, with the numbers: "d50 in compartment 2 moved by +17 % (41 -> 48 um)"
  double process_start = 0.0;  ///< process (PBM) clock [s]
  double process_end = 0.0;    ///< [s]
  double dem_start = 0.0;      ///< DEM clock [s]
  double dem_end = 0.0;        ///< [s]
  double wall = 0.0;           ///< [s]
  std::int64_t cores = 0;      ///< it ran on
  std::int64_t exit_code = 0;  ///< of its program
  double coarse_graining = 1.0;  ///< DEM diameter over real diameter [-]
  double dem_particles = 0.0;    ///< in the DEM at its end [-]
  double d50 = 0.0;              ///< of all compartments together, by volume, at its end [m]
  double particles = 0.0;        ///< in the PBM, all compartments, at its end [-]
  bool operator==(const BurstSummary&) const = default;
};

/// The PBM over the whole process, the bursts' progress.jsonl joined. T times, X compartments.
struct PbmSeries {
  std::vector<double> time;                                ///< process clock [s], shape (T)
  std::vector<std::int64_t> burst;                         ///< number of the burst the row is of, shape (T)
  Rows number;                                             ///< particles [-], shape (T, X)
  Rows d10, d50, d90;                                      ///< by volume [m], shape (T, X)
  Rows porosity;                                           ///< (liquid + gas) / volume [-], shape (T, X)
  Rows solid, liquid, gas;                                 ///< hold-up [m^3], shape (T, X)
  std::vector<double> outlet_d10, outlet_d50, outlet_d90;  ///< [m], shape (T)
  std::vector<double> outlet_solid;                        ///< [kg/s], shape (T)
  std::vector<double> outlet_number;                       ///< [1/s], shape (T)
  std::vector<double> outlet_liquid_fraction;              ///< liquid / volume [-], shape (T)
  /// |hold-up - start - in + out| over what ever was in [-], shape (T)
  std::vector<double> drift_solid_1, drift_solid_2, drift_liquid, drift_gas;
  std::vector<double> oversize;  ///< solid volume that left the grid at its top [m^3], shape (T)
  bool operator==(const PbmSeries&) const = default;
};

/// Share of the volume in each of D diameter classes, at S moments: start, after each PBM burst, end. Shares of one
/// distribution add up to 1; all 0 where there was nothing.
struct SizeDistributions {
  std::vector<double> edge;       ///< class edges, ascending [m], shape (D + 1)
  std::vector<std::string> when;  ///< "start", "after burst 2", "end", shape (S)
  std::vector<double> time;       ///< process clock [s], shape (S)
  Tables compartments;            ///< volume share [-], shape (S, X, D)
  Rows outlet;                    ///< volume share of what flows out [-], shape (S, D)
  bool operator==(const SizeDistributions&) const = default;
};

/// The DEM over all its bursts, one row a window of tallies.jsonl. W windows, B bodies, K size classes (NaN for a class
/// that the burst of that row does not have).
struct DemSeries {
  std::vector<std::string> bodies;      ///< "shell", "impeller", shape (B)
  std::vector<double> time;             ///< DEM clock [s], shape (W)
  std::vector<std::int64_t> burst;      ///< number of the burst the row is of, shape (W)
  std::vector<double> particles;        ///< in the DEM [-], shape (W)
  std::vector<double> collisions;       ///< that began, per time, as simulated [1/s], shape (W)
  Rows impacts;                         ///< on each body, per time, as simulated [1/s], shape (W, B)
  Rows torque;                          ///< that turns each body, about its axis [N m], shape (W, B); NaN: not known
  Rows power;                           ///< each body gives to the particles [W], shape (W, B); NaN: not known
  Rows speed;                           ///< mean speed of each class [m/s], shape (W, K)
  std::vector<double> kinetic_energy;   ///< [J], shape (W)
  std::vector<double> largest_overlap;  ///< over the particle's radius [-], shape (W)
  bool operator==(const DemSeries&) const = default;
};

/// Log-normal fit and histogram of speeds at first touch.
struct SpeedHistogram {
  std::vector<double> edge;   ///< [m/s], ascending, shape (H + 1)
  std::vector<double> count;  ///< contacts [-], shape (H)
  double ln_mean = 0.0;       ///< mean of ln(U / (m/s)) [-]
  double ln_sigma = 0.0;      ///< standard deviation of ln(U / (m/s)) [-]
  bool operator==(const SpeedHistogram&) const = default;
};

/// What one DEM burst gave to the PBM, carried to real sizes. K size classes (they may differ from burst to burst).
struct DemRates {
  std::int64_t burst = 0;                 ///< number of the DEM burst
  double measured = 0.0;                  ///< DEM time the means were taken over [s]
  std::vector<double> diameter;           ///< class centres, real sizes [m], shape (K)
  Rows collisions;                        ///< contacts counted, each unordered pair once [-], shape (K, K)
  Rows collision_rate;                    ///< C_pq [m^3/s], symmetric, shape (K, K)
  Rows collision_rate_error;              ///< its standard error [m^3/s], shape (K, K)
  std::vector<double> impact_rate;        ///< impacts per particle with walls and blades [1/s], shape (K)
  std::vector<double> impact_rate_error;  ///< its standard error [1/s], shape (K)
  SpeedHistogram collision_speed;         ///< relative normal speed of two particles
  SpeedHistogram impact_speed;            ///< relative normal speed of particle and wall
  bool operator==(const DemRates&) const = default;
};

/// One stretch of one attempt of a task on its cores; a suspended filler has one entry for each stretch it ran.
struct TimelineEntry {
  std::string task;                 ///< "0001-dem"
  std::string kind;                 ///< dem | pbm | monitor | estimation | other
  std::int64_t attempt = 1;         ///< from 1
  std::vector<std::int64_t> cores;  ///< by their place in the allocation, from 0; empty for a monitor: it occupies none
  double start = 0.0;               ///< wall time since the campaign began [s]
  double end = 0.0;                 ///< [s]
  bool operator==(const TimelineEntry&) const = default;
};

/// What one kind of task used.
struct KindUse {
  std::string kind;           ///< dem | pbm | monitor | estimation | other
  double wall = 0.0;          ///< in which at least one such task ran [s]
  double core_seconds = 0.0;  ///< on the cores it occupied [core s]
  bool operator==(const KindUse&) const = default;
};

/// Where the allocation's time went.
struct CoreUse {
  std::int64_t cores = 0;   ///< of the allocation
  double wall = 0.0;        ///< the campaign took [s]
  double idle = 0.0;        ///< in which no task occupied any core [s]
  double busy_share = 0.0;  ///< core seconds of all tasks over cores * wall [-]
  std::vector<KindUse> kinds;
  bool operator==(const CoreUse&) const = default;
};

/// "What was modelled, what was left out, and what each choice is worth." Texts for people, with units;
/// "not measured" where nothing was.
struct ModelChoice {
  std::string choice;  ///< "DEM time step"
  std::string value;   ///< "5 us (2.1 % of the Hertz contact time)"
  std::string error;   ///< "collision rate +1.2 +- 0.8 % against 1 us"
  std::string cost;    ///< "4.8x cheaper than 1 us"
  bool operator==(const ModelChoice&) const = default;
};

struct CampaignResults {
  Provenance provenance;
  std::string ended;    ///< steady | limit | stopped | failed
  std::string message;  ///< why, in a sentence with the numbers
  std::vector<BurstSummary> bursts;
  PbmSeries pbm;
  SizeDistributions sizes;
  DemSeries dem;
  std::vector<DemRates> rates;  ///< one for each DEM burst that gave rates
  std::vector<TimelineEntry> timeline;
  CoreUse core_use;
  std::vector<ModelChoice> choices;
  EstimationSummary estimation;
  bool operator==(const CampaignResults&) const = default;
};

/// Seconds and core seconds of each kind (in the order dem, pbm, monitor, estimation, other; kinds that never ran are
/// left out), overlaps counted once in `wall`. A core that two entries claim at the same time counts once in
/// busy_share.
CoreUse core_use(const std::vector<TimelineEntry>& timeline, std::int64_t cores, double wall);

/// Writes results.h5: beside the file first, then renamed over it, so that a reader sees the old file or the new one.
/// Errors: series of unequal length (names the dataset; Exit::internal); the file cannot be written, for example
/// because the disk is full (Exit::task_failed; the old file stays).
Status write_results(const CampaignResults& results, const std::filesystem::path& h5);

/// Reads what write_results wrote, bit for bit.
/// Errors: no such file, not a results file, another format version, a missing dataset or one of the wrong shape; each
/// names the file.
Result<CampaignResults> read_results(const std::filesystem::path& h5);

}  // namespace granary
