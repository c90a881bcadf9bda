// The one place where the datasets of results.h5 have their names, shapes, units and descriptions.
// A shape is a list of sizes: "T X" means T rows of X numbers; equal letters are equal sizes within the file
// (within a group for /rates/NNNN). "D+1" is one more than D.  Told to users in docs/results_format.md; a test compares
// the two.
#pragma once

#include <array>
#include <string_view>

namespace granary::results_schema {

inline constexpr std::string_view kFormat = "granary-results-1";  ///< root attribute "format"
inline constexpr double kFileVersion = 2;  ///< root attribute "version": grows when datasets are added

struct Dataset {
  std::string_view name;         ///< full path
  std::string_view shape;        ///< sizes by their letters
  std::string_view unit;         ///< SI; "1" if dimensionless, "text" for texts
  std::string_view description;  ///< one sentence
};

// Provenance: who ran what, where, from which settings. One text each.
inline constexpr Dataset kName{"/provenance/name", "1", "text", "name of the campaign"};
inline constexpr Dataset kKind{"/provenance/kind", "1", "text", "kind of the workflow: coupled, tasks, sweep"};
inline constexpr Dataset kVersion{"/provenance/version", "1", "text", "version of Granary"};
inline constexpr Dataset kRevision{"/provenance/revision", "1", "text", "commit Granary was built from"};
inline constexpr Dataset kHost{"/provenance/host", "1", "text", "machine and cores it ran on"};
inline constexpr Dataset kStarted{"/provenance/started", "1", "text", "wall clock at the start, ISO 8601, UTC"};
inline constexpr Dataset kFinished{"/provenance/finished", "1", "text", "wall clock at the end, ISO 8601, UTC"};
inline constexpr Dataset kCampaignJson{"/provenance/campaign_json", "1", "text",
                                       "campaign.json: the workflow as understood"};
inline constexpr Dataset kVersionOf{"/provenance/version_of", "V", "text", "program or library"};
inline constexpr Dataset kVersionValue{"/provenance/version_value", "V", "text", "its version"};
inline constexpr Dataset kSeedOf{"/provenance/seed_of", "G", "text", "what the seed is for"};
inline constexpr Dataset kSeedValue{"/provenance/seed_value", "G", "text", "the seed, a decimal integer"};

// How it ended.
inline constexpr Dataset kEnded{"/summary/ended", "1", "text", "steady, limit, stopped or failed"};
inline constexpr Dataset kMessage{"/summary/message", "1", "text", "why, in a sentence"};
inline constexpr Dataset kCores{"/summary/cores", "1", "1", "cores of the allocation"};
inline constexpr Dataset kWall{"/summary/wall", "1", "s", "wall time of the campaign"};
inline constexpr Dataset kIdle{"/summary/idle", "1", "s", "wall time in which no task occupied any core"};
inline constexpr Dataset kBusyShare{"/summary/busy_share", "1", "1",
                                    "core seconds of all tasks over cores times wall time"};
inline constexpr Dataset kUseKind{"/summary/kind", "U", "text", "kind of task: dem, pbm, monitor, estimation, other"};
inline constexpr Dataset kUseWall{"/summary/kind_wall", "U", "s",
                                  "wall time in which at least one task of the kind ran"};
inline constexpr Dataset kUseCoreSeconds{"/summary/kind_core_seconds", "U", "s", "core seconds the kind occupied"};

// One row a burst; NaN where a number does not exist for that kind of burst.
inline constexpr Dataset kBurstNumber{"/bursts/number", "N", "1", "number of the burst, from 1"};
inline constexpr Dataset kBurstKind{"/bursts/kind", "N", "text", "dem or pbm"};
inline constexpr Dataset kBurstReason{"/bursts/reason", "N", "text", "why it ended, with the numbers"};
inline constexpr Dataset kBurstProcessStart{"/bursts/process_start", "N", "s", "process clock at its start"};
inline constexpr Dataset kBurstProcessEnd{"/bursts/process_end", "N", "s", "process clock at its end"};
inline constexpr Dataset kBurstDemStart{"/bursts/dem_start", "N", "s", "DEM clock at its start"};
inline constexpr Dataset kBurstDemEnd{"/bursts/dem_end", "N", "s", "DEM clock at its end"};
inline constexpr Dataset kBurstWall{"/bursts/wall", "N", "s", "wall time it took"};
inline constexpr Dataset kBurstCores{"/bursts/cores", "N", "1", "cores it ran on"};
inline constexpr Dataset kBurstExit{"/bursts/exit_code", "N", "1", "exit code of its program"};
inline constexpr Dataset kBurstCoarse{"/bursts/coarse_graining", "N", "1", "DEM diameter over real diameter"};
inline constexpr Dataset kBurstDemParticles{"/bursts/dem_particles", "N", "1", "particles in the DEM at its end"};
inline constexpr Dataset kBurstD50{"/bursts/d50", "N", "m",
                                   "median diameter by volume of all compartments together at its end"};
inline constexpr Dataset kBurstParticles{"/bursts/particles", "N", "1",
                                         "particles in the PBM, all compartments, at its end"};

// The PBM over the whole process: T times, X compartments.
inline constexpr Dataset kPbmTime{"/pbm/time", "T", "s", "process clock"};
inline constexpr Dataset kPbmBurst{"/pbm/burst", "T", "1", "number of the burst the row is of"};
inline constexpr Dataset kPbmNumber{"/pbm/number", "T X", "1", "particles in each compartment"};
inline constexpr Dataset kPbmD10{"/pbm/d10", "T X", "m", "diameter below which 10 % of the volume lies"};
inline constexpr Dataset kPbmD50{"/pbm/d50", "T X", "m", "diameter below which half of the volume lies"};
inline constexpr Dataset kPbmD90{"/pbm/d90", "T X", "m", "diameter below which 90 % of the volume lies"};
inline constexpr Dataset kPbmPorosity{"/pbm/porosity", "T X", "1", "liquid and gas volume over particle volume"};
inline constexpr Dataset kPbmSolid{"/pbm/solid", "T X", "m^3", "solid volume in each compartment"};
inline constexpr Dataset kPbmLiquid{"/pbm/liquid", "T X", "m^3", "liquid volume in the particles of each compartment"};
inline constexpr Dataset kPbmGas{"/pbm/gas", "T X", "m^3", "gas volume in the particles of each compartment"};
inline constexpr Dataset kOutletD10{"/pbm/outlet_d10", "T", "m", "d10 of what flows out"};
inline constexpr Dataset kOutletD50{"/pbm/outlet_d50", "T", "m", "d50 of what flows out"};
inline constexpr Dataset kOutletD90{"/pbm/outlet_d90", "T", "m", "d90 of what flows out"};
inline constexpr Dataset kOutletSolid{"/pbm/outlet_solid", "T", "kg/s", "solid mass flowing out"};
inline constexpr Dataset kOutletNumber{"/pbm/outlet_number", "T", "1/s", "particles flowing out"};
inline constexpr Dataset kOutletLiquid{"/pbm/outlet_liquid_fraction", "T", "1",
                                       "liquid volume over particle volume of what flows out"};
inline constexpr Dataset kDriftSolid1{"/pbm/drift_solid_1", "T", "1",
                                      "error of the balance of solid 1 over what ever was in"};
inline constexpr Dataset kDriftSolid2{"/pbm/drift_solid_2", "T", "1",
                                      "error of the balance of solid 2 over what ever was in"};
inline constexpr Dataset kDriftLiquid{"/pbm/drift_liquid", "T", "1",
                                      "error of the balance of liquid over what ever was in"};
inline constexpr Dataset kDriftGas{"/pbm/drift_gas", "T", "1", "error of the balance of gas over what ever was in"};
inline constexpr Dataset kOversize{"/pbm/oversize", "T", "m^3", "solid volume that left the grid at its top"};

// Size distributions by volume: S moments, X compartments, D diameter classes.
inline constexpr Dataset kSizeEdge{"/sizes/edge", "D+1", "m", "edges of the diameter classes, ascending"};
inline constexpr Dataset kSizeWhen{"/sizes/when", "S", "text", "the moment: start, after burst 2, end"};
inline constexpr Dataset kSizeTime{"/sizes/time", "S", "s", "process clock"};
inline constexpr Dataset kSizeCompartments{"/sizes/compartments", "S X D", "1",
                                           "volume share of each class in each compartment"};
inline constexpr Dataset kSizeOutlet{"/sizes/outlet", "S D", "1", "volume share of each class in what flows out"};

// The DEM over all bursts: W windows, B bodies, C size classes (NaN for a class a burst does not have).
inline constexpr Dataset kDemBodies{"/dem/bodies", "B", "text", "walls and blades"};
inline constexpr Dataset kDemTime{"/dem/time", "W", "s", "DEM clock"};
inline constexpr Dataset kDemBurst{"/dem/burst", "W", "1", "number of the burst the row is of"};
inline constexpr Dataset kDemParticles{"/dem/particles", "W", "1", "particles in the DEM"};
inline constexpr Dataset kDemCollisions{"/dem/collisions", "W", "1/s",
                                        "collisions between particles that began, per time, as simulated"};
inline constexpr Dataset kDemImpacts{"/dem/impacts", "W B", "1/s",
                                     "impacts on each body that began, per time, as simulated"};
inline constexpr Dataset kDemTorque{"/dem/torque", "W B", "N m",
                                    "torque that turns each body against the particles, about its axis"};
inline constexpr Dataset kDemPower{"/dem/power", "W B", "W", "power each body gives to the particles"};
inline constexpr Dataset kDemSpeed{"/dem/speed", "W C", "m/s", "mean speed of the particles of each size class"};
inline constexpr Dataset kDemEnergy{"/dem/kinetic_energy", "W", "J", "kinetic energy of all particles"};
inline constexpr Dataset kDemOverlap{"/dem/largest_overlap", "W", "1", "largest overlap over the particle's radius"};

// What each DEM burst gave to the PBM, at real sizes: one group a DEM burst, named by its number with four digits.
// K size classes, H and I speed classes; sizes may differ from group to group.
inline constexpr std::string_view kRatesGroup = "/rates";
inline constexpr Dataset kRateMeasured{"/rates/NNNN/measured", "1", "s", "DEM time the means were taken over"};
inline constexpr Dataset kRateDiameter{"/rates/NNNN/diameter", "K", "m", "centres of the size classes, real sizes"};
inline constexpr Dataset kRateCollisions{"/rates/NNNN/collisions", "K K", "1",
                                         "collisions counted, each pair of particles once"};
inline constexpr Dataset kRateCollision{"/rates/NNNN/collision_rate", "K K", "m^3/s",
                                        "collision rate coefficient C_pq"};
inline constexpr Dataset kRateCollisionError{"/rates/NNNN/collision_rate_error", "K K", "m^3/s",
                                             "standard error of C_pq"};
inline constexpr Dataset kRateImpact{"/rates/NNNN/impact_rate", "K", "1/s",
                                     "impacts per particle with walls and blades"};
inline constexpr Dataset kRateImpactError{"/rates/NNNN/impact_rate_error", "K", "1/s",
                                          "standard error of the impact rate"};
inline constexpr Dataset kCollisionSpeedEdge{"/rates/NNNN/collision_speed_edge", "H+1", "m/s",
                                             "edges of the collision speed classes"};
inline constexpr Dataset kCollisionSpeedCount{"/rates/NNNN/collision_speed_count", "H", "1",
                                              "collisions by relative normal speed"};
inline constexpr Dataset kCollisionLnMean{"/rates/NNNN/collision_ln_mean", "1", "1", "mean of ln(U s/m), collisions"};
inline constexpr Dataset kCollisionLnSigma{"/rates/NNNN/collision_ln_sigma", "1", "1",
                                           "standard deviation of ln(U s/m), collisions"};
inline constexpr Dataset kImpactSpeedEdge{"/rates/NNNN/impact_speed_edge", "I+1", "m/s",
                                          "edges of the impact speed classes"};
inline constexpr Dataset kImpactSpeedCount{"/rates/NNNN/impact_speed_count", "I", "1",
                                           "impacts by relative normal speed"};
inline constexpr Dataset kImpactLnMean{"/rates/NNNN/impact_ln_mean", "1", "1", "mean of ln(U s/m), impacts"};
inline constexpr Dataset kImpactLnSigma{"/rates/NNNN/impact_ln_sigma", "1", "1",
                                        "standard deviation of ln(U s/m), impacts"};

// What ran where: one row a stretch of an attempt of a task.
inline constexpr Dataset kTask{"/timeline/task", "E", "text", "name of the task"};
inline constexpr Dataset kTaskKind{"/timeline/kind", "E", "text", "dem, pbm, monitor, estimation or other"};
inline constexpr Dataset kTaskAttempt{"/timeline/attempt", "E", "1", "attempt, from 1"};
inline constexpr Dataset kTaskCores{"/timeline/cores", "E", "text",
                                    "cores by their place in the allocation: 0,1; empty: none"};
inline constexpr Dataset kTaskStart{"/timeline/start", "E", "s", "wall time since the campaign began"};
inline constexpr Dataset kTaskEnd{"/timeline/end", "E", "s", "wall time since the campaign began"};

// What was modelled, what was left out, and what each choice is worth.
inline constexpr Dataset kChoice{"/choices/choice", "M", "text", "what was chosen"};
inline constexpr Dataset kChoiceValue{"/choices/value", "M", "text", "the choice"};
inline constexpr Dataset kChoiceError{"/choices/error", "M", "text", "the error it makes; not measured if nobody did"};
inline constexpr Dataset kChoiceCost{"/choices/cost", "M", "text",
                                     "what it costs or saves; not measured if nobody did"};

// An estimation beside the campaign: P parameters, Y data, Q evaluations, A adoptions, F outputs of the final run.
inline constexpr Dataset kFitName{"/estimation/parameter", "P", "text", "name of each parameter that was fitted"};
inline constexpr Dataset kFitKey{"/estimation/key", "P", "text", "its setting in the workflow"};
inline constexpr Dataset kFitUnit{"/estimation/parameter_unit", "P", "text", "unit of its values"};
inline constexpr Dataset kFitFrom{"/estimation/from", "P", "1",
                                  "lower bound, in the parameter's unit, as all of these"};
inline constexpr Dataset kFitTo{"/estimation/to", "P", "1", "upper bound"};
inline constexpr Dataset kFitStart{"/estimation/start", "P", "1", "the workflow's own value"};
inline constexpr Dataset kFitValue{"/estimation/value", "P", "1", "estimated value"};
inline constexpr Dataset kFitLow{"/estimation/low", "P", "1", "95 % interval, lower end; NaN if not known"};
inline constexpr Dataset kFitHigh{"/estimation/high", "P", "1", "95 % interval, upper end"};
inline constexpr Dataset kFitCorrelation{"/estimation/correlation", "P P", "1",
                                         "correlation of the parameters, on their scales; NaN if not known"};
inline constexpr Dataset kDatum{"/estimation/datum", "Y", "text", "what each datum is"};
inline constexpr Dataset kDatumUnit{"/estimation/datum_unit", "Y", "text", "its unit"};
inline constexpr Dataset kDatumTime{"/estimation/datum_time", "Y", "s", "its process time"};
inline constexpr Dataset kDatumMeasured{"/estimation/measured", "Y", "1", "as measured, in its unit"};
inline constexpr Dataset kDatumError{"/estimation/error", "Y", "1", "its standard deviation"};
inline constexpr Dataset kDatumFitted{"/estimation/fitted", "Y", "1", "by the model with the estimated values"};
inline constexpr Dataset kDatumHeldOut{"/estimation/held_out_datum", "Y", "1", "1 if it was not fitted, only checked"};
inline constexpr Dataset kTrialTime{"/estimation/evaluation_time", "Q", "s",
                                    "wall time of each evaluation since the campaign began"};
inline constexpr Dataset kTrialCost{"/estimation/evaluation_cost", "Q", "1",
                                    "half the sum of squares; NaN if it failed"};
inline constexpr Dataset kTrialVersion{"/estimation/evaluation_version", "Q", "1",
                                       "which rates it was made with, from 1"};
inline constexpr Dataset kAdoptedBy{"/estimation/adopted_by", "A", "text", "PBM burst that took the best values known"};
inline constexpr Dataset kAdoptedTime{"/estimation/adopted_time", "A", "s", "wall time since the campaign began"};
inline constexpr Dataset kAdopted{"/estimation/adopted", "A P", "1", "the values"};
inline constexpr Dataset kFinalTime{"/estimation/final_time", "F", "s",
                                    "process clock of the final run, with the estimated values"};
inline constexpr Dataset kFinalD10{"/estimation/final_d10", "F", "m", "d10 of what flows out in it"};
inline constexpr Dataset kFinalD50{"/estimation/final_d50", "F", "m", "d50 of what flows out in it"};
inline constexpr Dataset kFinalD90{"/estimation/final_d90", "F", "m", "d90 of what flows out in it"};
inline constexpr Dataset kFitWarnings{"/estimation/warnings", "Z", "text",
                                      "what to know before the estimate is trusted"};
inline constexpr Dataset kFitPhase{
    "/estimation/phase", "1", "text",
    "how far it came: search, uncertainty, posterior, done; empty if nothing was fitted"};
inline constexpr Dataset kFitMisfit{"/estimation/misfit", "1", "1",
                                    "sum of squares over data less parameters; about 1 if the errors are as stated"};
inline constexpr Dataset kFitHeldOut{"/estimation/held_out", "1", "1",
                                     "mean square of the held-out residuals; NaN if there are none"};
inline constexpr Dataset kFitUsed{"/estimation/used", "1", "s", "idle core seconds the estimation worked on"};
inline constexpr Dataset kFitLeft{"/estimation/left", "1", "s", "core seconds that nothing worked on"};
inline constexpr Dataset kFitCoupledWall{"/estimation/coupled_wall", "1", "s",
                                         "wall time of the coupling, without the final run"};

/// All of them, in the order they are written in.
inline constexpr std::array kAll{kName,
                                 kKind,
                                 kVersion,
                                 kRevision,
                                 kHost,
                                 kStarted,
                                 kFinished,
                                 kCampaignJson,
                                 kVersionOf,
                                 kVersionValue,
                                 kSeedOf,
                                 kSeedValue,
                                 kEnded,
                                 kMessage,
                                 kCores,
                                 kWall,
                                 kIdle,
                                 kBusyShare,
                                 kUseKind,
                                 kUseWall,
                                 kUseCoreSeconds,
                                 kBurstNumber,
                                 kBurstKind,
                                 kBurstReason,
                                 kBurstProcessStart,
                                 kBurstProcessEnd,
                                 kBurstDemStart,
                                 kBurstDemEnd,
                                 kBurstWall,
                                 kBurstCores,
                                 kBurstExit,
                                 kBurstCoarse,
                                 kBurstDemParticles,
                                 kBurstD50,
                                 kBurstParticles,
                                 kPbmTime,
                                 kPbmBurst,
                                 kPbmNumber,
                                 kPbmD10,
                                 kPbmD50,
                                 kPbmD90,
                                 kPbmPorosity,
                                 kPbmSolid,
                                 kPbmLiquid,
                                 kPbmGas,
                                 kOutletD10,
                                 kOutletD50,
                                 kOutletD90,
                                 kOutletSolid,
                                 kOutletNumber,
                                 kOutletLiquid,
                                 kDriftSolid1,
                                 kDriftSolid2,
                                 kDriftLiquid,
                                 kDriftGas,
                                 kOversize,
                                 kSizeEdge,
                                 kSizeWhen,
                                 kSizeTime,
                                 kSizeCompartments,
                                 kSizeOutlet,
                                 kDemBodies,
                                 kDemTime,
                                 kDemBurst,
                                 kDemParticles,
                                 kDemCollisions,
                                 kDemImpacts,
                                 kDemTorque,
                                 kDemPower,
                                 kDemSpeed,
                                 kDemEnergy,
                                 kDemOverlap,
                                 kRateMeasured,
                                 kRateDiameter,
                                 kRateCollisions,
                                 kRateCollision,
                                 kRateCollisionError,
                                 kRateImpact,
                                 kRateImpactError,
                                 kCollisionSpeedEdge,
                                 kCollisionSpeedCount,
                                 kCollisionLnMean,
                                 kCollisionLnSigma,
                                 kImpactSpeedEdge,
                                 kImpactSpeedCount,
                                 kImpactLnMean,
                                 kImpactLnSigma,
                                 kTask,
                                 kTaskKind,
                                 kTaskAttempt,
                                 kTaskCores,
                                 kTaskStart,
                                 kTaskEnd,
                                 kChoice,
                                 kChoiceValue,
                                 kChoiceError,
                                 kChoiceCost,
                                 kFitName,
                                 kFitKey,
                                 kFitUnit,
                                 kFitFrom,
                                 kFitTo,
                                 kFitStart,
                                 kFitValue,
                                 kFitLow,
                                 kFitHigh,
                                 kFitCorrelation,
                                 kDatum,
                                 kDatumUnit,
                                 kDatumTime,
                                 kDatumMeasured,
                                 kDatumError,
                                 kDatumFitted,
                                 kDatumHeldOut,
                                 kTrialTime,
                                 kTrialCost,
                                 kTrialVersion,
                                 kAdoptedBy,
                                 kAdoptedTime,
                                 kAdopted,
                                 kFinalTime,
                                 kFinalD10,
                                 kFinalD50,
                                 kFinalD90,
                                 kFitWarnings,
                                 kFitPhase,
                                 kFitMisfit,
                                 kFitHeldOut,
                                 kFitUsed,
                                 kFitLeft,
                                 kFitCoupledWall};

}  // namespace granary::results_schema
