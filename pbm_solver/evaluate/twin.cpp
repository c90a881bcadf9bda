#include "pbm_solver/evaluate/twin.hpp"

#include "common/assert.hpp"
#include "estimation/search/methods.hpp"
#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/evaluate/experiment_model.hpp"

namespace granary::pbm {
namespace {

using estimation::Dice;
using estimation::Parameter;
using estimation::Problem;
using estimation::Quantity;
using estimation::Scale;
using estimation::Target;

constexpr double kSmallest = 5e-13;  // [m^3]: 98 um
constexpr double kRatio = 3.5;
constexpr double kBatch = 1e6;  // particles of the powder

/// A wet powder of both solids in one small compartment.
void fill(PbmCase& c) {
  struct Part {
    int i, j;
    double share;
  };
  for (const Part& part : {Part{0, 0, 0.4}, Part{1, 0, 0.3}, Part{0, 1, 0.3}, Part{1, 1, 0.3}}) {
    InitialClass one;
    one.i = part.i, one.j = part.j;
    one.number = part.share * kBatch;
    const double solid = kSmallest * ((part.i > 0 ? kRatio : 1.0) + (part.j > 0 ? kRatio : 1.0)) * one.number;
    one.liquid = 0.2 * solid;
    one.gas = 0.6 * solid;
    c.initial.push_back(one);
  }
}

/// @param spray     liquid [m^3/s] over the first 20 s
/// @param ln_speed  mean of ln U of impacts [m/s]; collisions are half as fast
PbmCase granulation(double spray, double ln_speed) {
  PbmCase c;
  c.grid = {{6, 6}, {kSmallest, kSmallest}, {kRatio, kRatio}};
  c.compartments.volume = {1e-4};
  c.materials = {{1400.0, 1500.0}, 1000.0, 0.05, 0.3};
  c.spray = Spray{spray, 0, 0.0, 20.0};
  DemRates dem;
  dem.diameter = {1e-4, 2e-3};
  dem.impact_rate = {2.0, 20.0};
  dem.collision_speed = {ln_speed - 0.7, 0.8};
  dem.impact_speed = {ln_speed, 0.6};
  c.dem = dem;
  c.aggregation = Aggregation{};
  c.aggregation->kernel = Aggregation::Kernel::shear;
  c.aggregation->efficiency = {Efficiency::Model::stokes, 1.0, 0.2, 0.3, 5e-6};
  c.breakage = Breakage{};
  c.breakage->primary_diameter = 2e-5;
  c.consolidation = Consolidation{0.05, 0.15};
  c.end_time = 40.0;
  c.output_every = 5.0;
  c.relative_tolerance = c.kernel_tolerance = 1e-2;
  fill(c);
  return c;
}

void add_targets(Problem& p, const char* experiment) {
  for (const double time : {5.0, 10.0, 20.0, 30.0, 40.0})
    for (const Quantity q : {Quantity::d10, Quantity::d50, Quantity::d90, Quantity::porosity, Quantity::number}) {
      Target t;
      t.experiment = experiment;
      t.quantity = q;
      t.time = time;
      t.held_out = time == 30.0;
      t.error = 1.0;  // until the value is known
      p.targets.push_back(t);
    }
}

/// Hides parameters, and makes the data with them.
Twin with_data(Problem problem, std::uint64_t seed) {
  Dice dice(seed);
  Twin twin;
  for (const Parameter& p : problem.parameters) twin.truth.push_back(p.value_at(0.35 + 0.3 * dice.uniform()));
  const auto model = ExperimentModel::prepare(problem, "twin");
  GRANARY_ASSERT(model.has_value());
  const auto exact = model->run(twin.truth, 1e300);
  GRANARY_ASSERT(exact.has_value());
  for (std::size_t k = 0; k < problem.targets.size(); ++k) {
    Target& t = problem.targets[k];
    t.error = t.quantity == Quantity::porosity ? 0.01 : 0.05 * (*exact)[k];
    t.value = (*exact)[k] + t.error * dice.normal();
  }
  twin.problem = std::move(problem);
  return twin;
}

Problem two_batches(void (*adapt)(PbmCase&)) {
  Problem p;
  for (const auto& [name, spray, ln_speed] : {std::tuple{"wet", 3e-8, 0.0}, std::tuple{"dry", 1.5e-8, 0.7}}) {
    PbmCase c = granulation(spray, ln_speed);
    adapt(c);
    p.experiments.push_back({name, {to_json(c)}});
    add_targets(p, name);
  }
  return p;
}

Parameter on_log_scale(const char* name, const char* pointer, double low, double high) {
  return {name, pointer, low, high, Scale::log, {}, {}};
}

}  // namespace

Twin make_twin(int n_parameters, std::uint64_t seed) {
  Problem p = two_batches([](PbmCase& c) { c.aggregation->rate = 0.2, c.breakage->rate = 0.1; });
  p.parameters = {on_log_scale("aggregation rate", "/aggregation/rate", 2e-3, 20.0),
                  on_log_scale("breakage rate", "/breakage/rate", 1e-3, 10.0),
                  on_log_scale("consolidation rate", "/consolidation/rate", 5e-3, 0.5),
                  on_log_scale("critical Stokes deformation", "/breakage/critical_stokes_deformation", 1e-2, 1.0),
                  on_log_scale("asperity", "/aggregation/efficiency/asperity", 1e-6, 2.5e-5),
                  {"least porosity", "/consolidation/least_porosity", 0.05, 0.25, Scale::linear, {}, {}}};
  GRANARY_ASSERT(n_parameters <= static_cast<int>(p.parameters.size()));
  p.parameters.resize(static_cast<std::size_t>(n_parameters));
  return with_data(std::move(p), seed);
}

Twin make_product_twin(std::uint64_t seed) {
  Problem p = two_batches([](PbmCase& c) {
    c.aggregation->efficiency.model = Efficiency::Model::constant;
    c.breakage->rate = 0.1;
  });
  p.parameters = {on_log_scale("aggregation rate", "/aggregation/rate", 2e-3, 2.0),
                  {"efficiency", "/aggregation/efficiency/value", 1e-3, 1.0, Scale::log, {}, {}},
                  on_log_scale("consolidation rate", "/consolidation/rate", 5e-3, 0.5)};
  return with_data(std::move(p), seed);
}

}  // namespace granary::pbm
