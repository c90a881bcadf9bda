#include "common/results/campaign_results.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <charconv>

#include "common/files.hpp"
#include "common/results/dataset_io.hpp"
#include "common/results/hdf5_file.hpp"
#include "common/results/schema.hpp"

namespace granary {
namespace fs = std::filesystem;
namespace schema = results_schema;
namespace {

// Which member is which dataset: told once, for both directions. `Io` is DatasetWriter (const structs) or
// DatasetReader.

template <class Io, class P>
void exchange_provenance(Io& io, P& p) {
  io.scalar(schema::kName, p.name);
  io.scalar(schema::kKind, p.kind);
  io.scalar(schema::kVersion, p.version);
  io.scalar(schema::kRevision, p.revision);
  io.scalar(schema::kHost, p.host);
  io.scalar(schema::kStarted, p.started);
  io.scalar(schema::kFinished, p.finished);
  io.scalar(schema::kCampaignJson, p.campaign_json);
  io.column(schema::kVersionOf, p.versions, &Provenance::Version::of);
  io.column(schema::kVersionValue, p.versions, &Provenance::Version::value);
  io.column(schema::kSeedOf, p.seeds, &Provenance::Seed::of);
  io.column(schema::kSeedValue, p.seeds, &Provenance::Seed::value);
}

template <class Io, class R>
void exchange_summary(Io& io, R& r) {
  io.scalar(schema::kEnded, r.ended);
  io.scalar(schema::kMessage, r.message);
  io.scalar(schema::kCores, r.core_use.cores);
  io.scalar(schema::kWall, r.core_use.wall);
  io.scalar(schema::kIdle, r.core_use.idle);
  io.scalar(schema::kBusyShare, r.core_use.busy_share);
  io.column(schema::kUseKind, r.core_use.kinds, &KindUse::kind);
  io.column(schema::kUseWall, r.core_use.kinds, &KindUse::wall);
  io.column(schema::kUseCoreSeconds, r.core_use.kinds, &KindUse::core_seconds);
}

template <class Io, class B>
void exchange_bursts(Io& io, B& bursts) {
  io.column(schema::kBurstNumber, bursts, &BurstSummary::number);
  io.column(schema::kBurstKind, bursts, &BurstSummary::kind);
  io.column(schema::kBurstReason, bursts, &BurstSummary::reason);
  io.column(schema::kBurstProcessStart, bursts, &BurstSummary::process_start);
  io.column(schema::kBurstProcessEnd, bursts, &BurstSummary::process_end);
  io.column(schema::kBurstDemStart, bursts, &BurstSummary::dem_start);
  io.column(schema::kBurstDemEnd, bursts, &BurstSummary::dem_end);
  io.column(schema::kBurstWall, bursts, &BurstSummary::wall);
  io.column(schema::kBurstCores, bursts, &BurstSummary::cores);
  io.column(schema::kBurstExit, bursts, &BurstSummary::exit_code);
  io.column(schema::kBurstCoarse, bursts, &BurstSummary::coarse_graining);
  io.column(schema::kBurstDemParticles, bursts, &BurstSummary::dem_particles);
  io.column(schema::kBurstD50, bursts, &BurstSummary::d50);
  io.column(schema::kBurstParticles, bursts, &BurstSummary::particles);
}

template <class Io, class P>
void exchange_pbm(Io& io, P& p) {
  io.list(schema::kPbmTime, p.time);
  io.list(schema::kPbmBurst, p.burst);
  io.rows(schema::kPbmNumber, p.number);
  io.rows(schema::kPbmD10, p.d10);
  io.rows(schema::kPbmD50, p.d50);
  io.rows(schema::kPbmD90, p.d90);
  io.rows(schema::kPbmPorosity, p.porosity);
  io.rows(schema::kPbmSolid, p.solid);
  io.rows(schema::kPbmLiquid, p.liquid);
  io.rows(schema::kPbmGas, p.gas);
  io.list(schema::kOutletD10, p.outlet_d10);
  io.list(schema::kOutletD50, p.outlet_d50);
  io.list(schema::kOutletD90, p.outlet_d90);
  io.list(schema::kOutletSolid, p.outlet_solid);
  io.list(schema::kOutletNumber, p.outlet_number);
  io.list(schema::kOutletLiquid, p.outlet_liquid_fraction);
  io.list(schema::kDriftSolid1, p.drift_solid_1);
  io.list(schema::kDriftSolid2, p.drift_solid_2);
  io.list(schema::kDriftLiquid, p.drift_liquid);
  io.list(schema::kDriftGas, p.drift_gas);
  io.list(schema::kOversize, p.oversize);
}

template <class Io, class S>
void exchange_sizes(Io& io, S& s) {
  io.list(schema::kSizeEdge, s.edge);
  io.list(schema::kSizeWhen, s.when);
  io.list(schema::kSizeTime, s.time);
  io.tables(schema::kSizeCompartments, s.compartments);
  io.rows(schema::kSizeOutlet, s.outlet);
}

template <class Io, class D>
void exchange_dem(Io& io, D& d) {
  io.list(schema::kDemBodies, d.bodies);
  io.list(schema::kDemTime, d.time);
  io.list(schema::kDemBurst, d.burst);
  io.list(schema::kDemParticles, d.particles);
  io.list(schema::kDemCollisions, d.collisions);
  io.rows(schema::kDemImpacts, d.impacts);
  io.rows(schema::kDemTorque, d.torque);
  io.rows(schema::kDemPower, d.power);
  io.rows(schema::kDemSpeed, d.speed);
  io.list(schema::kDemEnergy, d.kinetic_energy);
  io.list(schema::kDemOverlap, d.largest_overlap);
}

template <class Io, class E>
void exchange_estimation(Io& io, E& e) {
  using Parameter = EstimationSummary::Parameter;
  using Datum = EstimationSummary::Datum;
  io.column(schema::kFitName, e.parameters, &Parameter::name);
  io.column(schema::kFitKey, e.parameters, &Parameter::key);
  io.column(schema::kFitUnit, e.parameters, &Parameter::unit);
  io.column(schema::kFitFrom, e.parameters, &Parameter::from);
  io.column(schema::kFitTo, e.parameters, &Parameter::to);
  io.column(schema::kFitStart, e.parameters, &Parameter::start);
  io.column(schema::kFitValue, e.parameters, &Parameter::value);
  io.column(schema::kFitLow, e.parameters, &Parameter::low);
  io.column(schema::kFitHigh, e.parameters, &Parameter::high);
  io.rows(schema::kFitCorrelation, e.correlation);
  io.column(schema::kDatum, e.data, &Datum::what);
  io.column(schema::kDatumUnit, e.data, &Datum::unit);
  io.column(schema::kDatumTime, e.data, &Datum::time);
  io.column(schema::kDatumMeasured, e.data, &Datum::measured);
  io.column(schema::kDatumError, e.data, &Datum::error);
  io.column(schema::kDatumFitted, e.data, &Datum::fitted);
  io.column(schema::kDatumHeldOut, e.data, &Datum::held_out);
  io.list(schema::kTrialTime, e.time);
  io.list(schema::kTrialCost, e.cost);
  io.list(schema::kTrialVersion, e.version);
  io.list(schema::kAdoptedBy, e.adopted_by);
  io.list(schema::kAdoptedTime, e.adopted_time);
  io.rows(schema::kAdopted, e.adopted);
  io.list(schema::kFinalTime, e.final_time);
  io.list(schema::kFinalD10, e.final_d10);
  io.list(schema::kFinalD50, e.final_d50);
  io.list(schema::kFinalD90, e.final_d90);
  io.list(schema::kFitWarnings, e.warnings);
  io.scalar(schema::kFitPhase, e.phase);
  io.scalar(schema::kFitMisfit, e.misfit);
  io.scalar(schema::kFitHeldOut, e.held_out);
  io.scalar(schema::kFitUsed, e.used);
  io.scalar(schema::kFitLeft, e.left);
  io.scalar(schema::kFitCoupledWall, e.coupled_wall);
}

template <class Io, class R>
void exchange_rates(Io& io, R& r) {
  io.enter(r.burst);
  io.scalar(schema::kRateMeasured, r.measured);
  io.list(schema::kRateDiameter, r.diameter);
  io.rows(schema::kRateCollisions, r.collisions);
  io.rows(schema::kRateCollision, r.collision_rate);
  io.rows(schema::kRateCollisionError, r.collision_rate_error);
  io.list(schema::kRateImpact, r.impact_rate);
  io.list(schema::kRateImpactError, r.impact_rate_error);
  io.list(schema::kCollisionSpeedEdge, r.collision_speed.edge);
  io.list(schema::kCollisionSpeedCount, r.collision_speed.count);
  io.scalar(schema::kCollisionLnMean, r.collision_speed.ln_mean);
  io.scalar(schema::kCollisionLnSigma, r.collision_speed.ln_sigma);
  io.list(schema::kImpactSpeedEdge, r.impact_speed.edge);
  io.list(schema::kImpactSpeedCount, r.impact_speed.count);
  io.scalar(schema::kImpactLnMean, r.impact_speed.ln_mean);
  io.scalar(schema::kImpactLnSigma, r.impact_speed.ln_sigma);
}

template <class Io, class R>
void exchange(Io& io, R& r) {
  exchange_provenance(io, r.provenance);
  exchange_summary(io, r);
  exchange_bursts(io, r.bursts);
  exchange_pbm(io, r.pbm);
  exchange_sizes(io, r.sizes);
  exchange_dem(io, r.dem);
  io.column(schema::kTask, r.timeline, &TimelineEntry::task);
  io.column(schema::kTaskKind, r.timeline, &TimelineEntry::kind);
  io.column(schema::kTaskAttempt, r.timeline, &TimelineEntry::attempt);
  io.column(schema::kTaskCores, r.timeline, &TimelineEntry::cores);
  io.column(schema::kTaskStart, r.timeline, &TimelineEntry::start);
  io.column(schema::kTaskEnd, r.timeline, &TimelineEntry::end);
  io.column(schema::kChoice, r.choices, &ModelChoice::choice);
  io.column(schema::kChoiceValue, r.choices, &ModelChoice::value);
  io.column(schema::kChoiceError, r.choices, &ModelChoice::error);
  io.column(schema::kChoiceCost, r.choices, &ModelChoice::cost);
  exchange_estimation(io, r.estimation);
  for (auto& rates : r.rates) exchange_rates(io, rates);
}

/// Where the file is made before its bytes are written beside the real one. HDF5 forgets errno, and after a failed
/// flush (1.10) it can neither close the file nor end the process cleanly; made in memory and then written like any
/// other file of ours, a full disk is said as what it is.
class ScratchFile {
 public:
  ScratchFile() {
    static std::atomic<int> count = 0;
    std::error_code ignored;
    const fs::path memory = "/dev/shm";
    path_ = (fs::is_directory(memory, ignored) ? memory : fs::temp_directory_path(ignored)) /
            fmt::format("granary-results-{}-{}.h5", ::getpid(), ++count);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  ~ScratchFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

Status rates_are_in_order(const std::vector<DemRates>& rates) {
  for (std::size_t i = 0; i < rates.size(); ++i)
    if (rates[i].burst < 1 || (i > 0 && rates[i].burst <= rates[i - 1].burst))
      return Error{fmt::format("campaign results: the DEM rates of burst {} do not follow those of an earlier burst.",
                               rates[i].burst),
                   Exit::internal};
  return {};
}

Status write_datasets(const CampaignResults& results, const fs::path& file) {
  GRANARY_TRY(Hdf5File h5, Hdf5File::create(file));
  GRANARY_CHECK(h5.attribute("/", "format", schema::kFormat));
  GRANARY_CHECK(h5.attribute("/", "version", schema::kFileVersion));
  GRANARY_CHECK(
      h5.attribute(std::string(schema::kRatesGroup), "description", "one group a DEM burst, named by its number"));
  DatasetWriter writer(h5);
  exchange(writer, results);
  GRANARY_CHECK(writer.status());
  return h5.flush();
}

Status is_results_file(const Hdf5File& h5, const fs::path& file) {
  const auto format = h5.text_attribute("/", "format");
  if (!format || *format != schema::kFormat)
    return Error{fmt::format("{}: is no results file of this Granary: its format is \"{}\"; \"{}\" is wanted.",
                             file.string(), format.value_or("none"), schema::kFormat)};
  GRANARY_TRY(const double version, h5.number_attribute("/", "version"));
  if (version != schema::kFileVersion)
    return Error{
        fmt::format("{}: has version {} of {}; this Granary reads version {}. Read it with the Granary that wrote it.",
                    file.string(), version, schema::kFormat, schema::kFileVersion)};
  return {};
}

/// Empty rates with the numbers of their bursts, from the names of their groups.
Result<std::vector<DemRates>> rates_in(const Hdf5File& h5, const fs::path& file) {
  GRANARY_TRY(const auto groups, h5.children(std::string(schema::kRatesGroup)));
  std::vector<DemRates> rates;
  for (const auto& group : groups) {
    DemRates one;
    const auto [end, code] = std::from_chars(group.data(), group.data() + group.size(), one.burst);
    if (code != std::errc{} || end != group.data() + group.size())
      return Error{fmt::format("{}: {}/{} is no number of a burst.", file.string(), schema::kRatesGroup, group)};
    rates.push_back(std::move(one));
  }
  return rates;
}

}  // namespace

Status write_results(const CampaignResults& results, const fs::path& h5) {
  GRANARY_CHECK(rates_are_in_order(results.rates));
  const ScratchFile scratch;
  GRANARY_CHECK(write_datasets(results, scratch.path()));
  GRANARY_TRY(const std::string bytes, read_text(scratch.path()));
  return write_text_atomically(h5, bytes);
}

Result<CampaignResults> read_results(const fs::path& file) {
  GRANARY_TRY(const Hdf5File h5, Hdf5File::open(file));
  GRANARY_CHECK(is_results_file(h5, file));
  CampaignResults results;
  GRANARY_TRY(results.rates, rates_in(h5, file));
  DatasetReader reader(h5, file.string());
  exchange(reader, results);
  GRANARY_CHECK(reader.status());
  return results;
}

}  // namespace granary
