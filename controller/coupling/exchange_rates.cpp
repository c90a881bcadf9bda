// DEM -> PBM: tallies to rate coefficients.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "controller/coupling/exchange.hpp"
#include "controller/monitor/series_error.hpp"

namespace granary::coupling {

namespace {

using monitor::kInstant;
using monitor::SpeedMoments;
using monitor::Tallies;
using monitor::TallyWindow;

constexpr double kThinCounts = 100.0;     // counting error 10 %
constexpr double kLeastParticles = 20.0;  // of a class, to speak of its mean speed

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }
Matrix square(std::size_t n) { return Matrix(n, std::vector<double>(n, 0.0)); }
double exponent(ScalingLaw law) { return law == ScalingLaw::orthokinetic ? 3.0 : 2.0; }

template <class F>
void for_each_pair(std::size_t n, F&& visit) {
  for (std::size_t p = 0; p < n; ++p)
    for (std::size_t q = p; q < n; ++q) visit(p, q);
}

std::vector<const TallyWindow*> after_grace(const Tallies& tallies, double grace) {
  std::vector<const TallyWindow*> used;
  if (tallies.windows.empty()) return used;
  const double from = tallies.windows.front().time - tallies.windows.front().window + grace;
  for (const TallyWindow& window : tallies.windows)
    if (window.time - window.window >= from - kInstant) used.push_back(&window);
  return used;
}

/// What was counted, and for how long and among how many, at DEM sizes.
struct Counted {
  std::vector<double> diameter;     ///< shape (n_classes)
  Matrix collisions, exposure;      ///< upper triangles (p <= q)
  std::vector<Matrix> exposure_in;  ///< by compartment
  std::vector<double> compartment_collisions;
  std::vector<double> impacts, particle_time;  ///< shape (n_classes); [particles s]
  double time = 0.0;                           ///< [s]
};

Counted count(const std::vector<const TallyWindow*>& windows, std::vector<double> diameter,
              const std::vector<double>& bed_volume) {
  const std::size_t n = diameter.size(), n_compartments = bed_volume.size();
  Counted c{std::move(diameter),
            square(n),
            square(n),
            std::vector<Matrix>(n_compartments, square(n)),
            std::vector<double>(n_compartments, 0.0),
            std::vector<double>(n, 0.0),
            std::vector<double>(n, 0.0),
            0.0};
  for (const TallyWindow* window : windows) {
    c.time += window->window;
    for_each_pair(n, [&](std::size_t p, std::size_t q) { c.collisions[p][q] += window->collisions[p][q]; });
    for (std::size_t p = 0; p < n; ++p) c.impacts[p] += window->impacts[p];
    for (std::size_t x = 0; x < n_compartments; ++x) {
      c.compartment_collisions[x] += window->collisions_by_compartment[x];
      const std::vector<double>& here = window->particles[x];
      for (std::size_t p = 0; p < n; ++p) c.particle_time[p] += here[p] * window->window;
      for_each_pair(n, [&](std::size_t p, std::size_t q) {
        const double pairs = p == q ? 0.5 * here[p] * std::max(here[p] - 1.0, 0.0) : here[p] * here[q];
        c.exposure_in[x][p][q] += pairs * window->window / bed_volume[x];
      });
    }
  }
  for (const Matrix& in_compartment : c.exposure_in)
    for_each_pair(n, [&](std::size_t p, std::size_t q) { c.exposure[p][q] += in_compartment[p][q]; });
  return c;
}

void fill_collision_rates(MeasuredRates& out, const Counted& c, const RateSettings& settings) {
  const std::size_t n = c.diameter.size();
  const double m = exponent(settings.law), scale = out.carry.collision_rate, k = settings.prior_collisions;
  const auto shape = [&](std::size_t p, std::size_t q) { return std::pow(c.diameter[p] + c.diameter[q], m); };

  // Maximum likelihood for N_pq ~ Poisson(a shape_pq E_pq): total count over total expectation.
  double counted = 0.0, expected = 0.0;
  for_each_pair(n, [&](std::size_t p, std::size_t q) {
    counted += c.collisions[p][q];
    expected += shape(p, q) * c.exposure[p][q];
  });
  const double a = counted / expected;  // at DEM sizes
  out.shape_rate = a * scale * std::pow(out.coarse_graining, m);
  out.rates.collision_rate = out.standard_error = out.collisions = out.exposure = square(n);

  Matrix at_dem_size = square(n);
  for_each_pair(n, [&](std::size_t p, std::size_t q) {
    const double N = c.collisions[p][q], E = c.exposure[p][q], prior_exposure = k / (a * shape(p, q));
    at_dem_size[p][q] = (N + k) / (E + prior_exposure);
    if (N < kThinCounts) ++out.thin_pairs;
    out.rates.collision_rate[p][q] = out.rates.collision_rate[q][p] = scale * at_dem_size[p][q];
    out.standard_error[p][q] = out.standard_error[q][p] = scale * std::sqrt(N + k) / (E + prior_exposure);
    out.collisions[p][q] = out.collisions[q][p] = N;
    out.exposure[p][q] = out.exposure[q][p] = E;
  });

  out.compartment_collisions = c.compartment_collisions;
  for (std::size_t x = 0; x < c.exposure_in.size(); ++x) {
    double expected_here = 0.0;
    for_each_pair(n,
                  [&](std::size_t p, std::size_t q) { expected_here += at_dem_size[p][q] * c.exposure_in[x][p][q]; });
    out.rates.compartment_factor.push_back((c.compartment_collisions[x] + settings.prior_compartment) /
                                           (expected_here + settings.prior_compartment));
  }
}

void fill_impact_rates(MeasuredRates& out, const Counted& c, double k) {
  out.impacts = c.impacts;
  const double overall = sum(c.impacts) / sum(c.particle_time);
  for (std::size_t p = 0; p < c.impacts.size(); ++p)
    out.rates.impact_rate.push_back(
        overall > 0.0 ? out.carry.impact_rate * (c.impacts[p] + k) / (c.particle_time[p] + k / overall) : 0.0);
}

/// Mean and standard deviation of ln U over all windows together.
pbm::SpeedDistribution pool(const std::vector<const TallyWindow*>& windows, SpeedMoments TallyWindow::*which) {
  double count = 0.0, first = 0.0, second = 0.0;
  for (const TallyWindow* window : windows) {
    const SpeedMoments& moments = window->*which;
    count += moments.count;
    first += moments.count * moments.ln_mean;
    second += moments.count * (moments.ln_variance + moments.ln_mean * moments.ln_mean);
  }
  if (!(count > 0.0)) return {};
  const double mean = first / count;
  constexpr double kLeastSigma = 1e-3;  // a single speed: narrow, but still a distribution to integrate over
  return {mean, std::max(std::sqrt(std::max(second / count - mean * mean, 0.0)), kLeastSigma)};
}

DemSummary summarize(const std::vector<const TallyWindow*>& windows, const Counted& c, const MeasuredRates& measured) {
  const std::size_t n = c.diameter.size();
  DemSummary summary;
  summary.start_time = windows.front()->time - windows.front()->window;
  summary.end_time = windows.back()->time;
  summary.coarse_graining = measured.coarse_graining;
  summary.class_diameter = measured.rates.diameter;
  summary.impacts = sum(c.impacts);
  for_each_pair(n, [&](std::size_t p, std::size_t q) { summary.collisions += c.collisions[p][q]; });
  const double particle_time = sum(c.particle_time);
  summary.particles = particle_time / c.time;
  const double carried = measured.carry.collision_rate * std::pow(measured.coarse_graining, 3);  // f^3 the particles
  summary.collision_frequency = 2.0 * summary.collisions / particle_time * carried;
  summary.impact_frequency = summary.impacts / particle_time * measured.carry.impact_rate;
  for (std::size_t p = 0; p < n; ++p) {
    double weight = 0.0, mean = 0.0, square_mean = 0.0;
    std::vector<double> means;
    for (const TallyWindow* window : windows) {
      const double particles = window->particles_by_class()[p];
      if (!(particles > 0.0) || !std::isfinite(window->speed_mean[p]) || !std::isfinite(window->speed_rms[p])) continue;
      weight += particles;
      means.push_back(window->speed_mean[p]);
      mean += particles * window->speed_mean[p];
      square_mean += particles * window->speed_rms[p] * window->speed_rms[p];
    }
    const double particles = c.particle_time[p] / c.time;
    const bool thin = particles < kLeastParticles || !(weight > 0.0);
    mean = thin ? std::nan("") : mean / weight;
    summary.mean_speed.push_back(mean);
    // Particles that move in flocks are fewer than they look: the scatter of the windows tells.
    const double by_counting = thin ? 0.0 : std::sqrt(std::max(square_mean / weight - mean * mean, 0.0) / particles);
    summary.mean_speed_error.push_back(thin ? 0.0 : std::max(by_counting, monitor::error_of_mean(means)));
  }
  return summary;
}

Status check(const Tallies& tallies, const std::vector<const TallyWindow*>& windows,
             const std::vector<double>& bed_volume, const RateSettings& settings) {
  const std::size_t n = tallies.header.n_classes(), n_compartments = tallies.header.n_compartments();
  if (tallies.diverged)
    return Error{fmt::format("the DEM burst diverged ({}): its rates are not used. {}", tallies.diverged->cause,
                             tallies.diverged->message)};
  if (bed_volume.size() != n_compartments)
    return Error{
        fmt::format("the DEM was tallied in {} compartments, the PBM has {}: they must be the same compartments.",
                    n_compartments, bed_volume.size())};
  for (std::size_t x = 0; x < bed_volume.size(); ++x)
    if (!(bed_volume[x] > 0.0))
      return Error{fmt::format("the bed volume of compartment {} is {} m^3; it must be > 0.", x + 1, bed_volume[x])};
  if (!settings.class_diameter.empty() && settings.class_diameter.size() != n)
    return Error{fmt::format("the DEM was tallied in {} size classes, the population has {}: tallies of another burst?",
                             n, settings.class_diameter.size())};
  if (windows.empty())
    return Error{fmt::format(
        "no DEM window begins after the grace time of {:.6g} s (the burst has {} windows). Make the burst longer "
        "(/dem/longest_burst) or the grace time shorter (/coupling/grace).",
        settings.grace, tallies.windows.size())};
  double particles = 0.0, collisions = 0.0;
  for (const TallyWindow* window : windows) {
    particles += window->total_particles();
    collisions += window->total_collisions();
  }
  if (!(particles > 0.0))
    return Error{"the DEM held no particles while it was measured. Check its population and its walls."};
  if (!(collisions > 0.0))
    return Error{
        fmt::format("no collision was counted in {} DEM windows, so there is no collision rate. Make the burst longer "
                    "(/dem/longest_burst) or give the DEM more particles (/dem/particles).",
                    windows.size())};
  return {};
}

}  // namespace

Carry carry_back(double coarse_graining, ScalingLaw law, const std::optional<CoarseGrainingLaw>& found) {
  const double from = found ? found->at : coarse_graining;
  Carry carry{.collision_rate = std::pow(from, -exponent(law)),
              .collision_speed = law == ScalingLaw::orthokinetic ? 1.0 / from : 1.0};
  if (!found) return carry;
  const double ratio = found->at / coarse_graining;
  carry.collision_rate *= std::pow(ratio, found->collision_rate);
  carry.collision_speed *= std::pow(ratio, found->collision_speed);
  carry.impact_rate = std::pow(ratio, found->impact_rate);
  carry.impact_speed = std::pow(ratio, found->impact_speed);
  return carry;
}

Result<MeasuredRates> measure_rates(const Tallies& tallies, const std::vector<double>& bed_volume,
                                    const RateSettings& settings) {
  const std::vector<const TallyWindow*> windows = after_grace(tallies, settings.grace);
  GRANARY_CHECK(check(tallies, windows, bed_volume, settings));

  std::vector<double> diameter = settings.class_diameter;
  const std::vector<double>& edge = tallies.header.class_edge;
  if (diameter.empty())
    for (std::size_t p = 0; p + 1 < edge.size(); ++p) diameter.push_back(std::sqrt(edge[p] * edge[p + 1]));
  const Counted counted = count(windows, diameter, bed_volume);
  double expected = 0.0;
  for_each_pair(diameter.size(), [&](std::size_t p, std::size_t q) { expected += counted.exposure[p][q]; });
  if (!(expected > 0.0))
    return Error{
        "the DEM counted collisions, but no compartment ever held two particles: its tallies contradict themselves."};

  MeasuredRates out;
  out.coarse_graining = tallies.header.coarse_graining;
  out.carry = carry_back(out.coarse_graining, settings.law, settings.found);
  out.windows = windows.size();
  for (const double d : diameter) out.rates.diameter.push_back(d / out.coarse_graining);
  fill_collision_rates(out, counted, settings);
  fill_impact_rates(out, counted, settings.prior_collisions);
  out.rates.collision_speed = pool(windows, &TallyWindow::collision_speed);
  out.rates.collision_speed.ln_mean += std::log(out.carry.collision_speed);
  out.rates.impact_speed = pool(windows, &TallyWindow::impact_speed);
  out.rates.impact_speed.ln_mean += std::log(out.carry.impact_speed);
  out.summary = summarize(windows, counted, out);
  return out;
}

json::Value to_json(const MeasuredRates& measured) {
  return json::Value::object(
      {{"coarse_graining", measured.coarse_graining},
       {"carried_by", json::Value::object({{"collision_rate", measured.carry.collision_rate},
                                           {"collision_speed", measured.carry.collision_speed},
                                           {"impact_rate", measured.carry.impact_rate},
                                           {"impact_speed", measured.carry.impact_speed}})},
       {"windows", measured.windows},
       {"thin_pairs", measured.thin_pairs},
       {"shape_rate", measured.shape_rate},
       {"diameter_m", measured.rates.diameter},
       {"collision_rate_m3_s", measured.rates.collision_rate},
       {"standard_error_m3_s", measured.standard_error},
       {"collisions", measured.collisions},
       {"compartment_factor", measured.rates.compartment_factor},
       {"compartment_collisions", measured.compartment_collisions},
       {"impact_rate_1_s", measured.rates.impact_rate},
       {"impacts", measured.impacts},
       {"collision_speed",
        std::vector<double>{measured.rates.collision_speed.ln_mean, measured.rates.collision_speed.ln_sigma}},
       {"impact_speed", std::vector<double>{measured.rates.impact_speed.ln_mean, measured.rates.impact_speed.ln_sigma}},
       {"summary", to_json(measured.summary)}});
}

}  // namespace granary::coupling
