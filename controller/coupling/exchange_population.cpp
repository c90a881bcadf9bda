// PBM -> DEM: the state of the population balance to particles.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "common/math/size_distribution.hpp"
#include "controller/coupling/exchange.hpp"

namespace granary::coupling {

namespace {

using Counts = std::vector<std::vector<long>>;  // shape (n_compartments, n_classes)

// Shares of the budget that f is chosen for, in this order: at first with room to grow and to shrink; less where single
// coarse particles make the count overshoot; more where the largest particle must stay small.
constexpr std::array kTriedShares{0.75, 0.65, 0.55, 0.45, 0.3, 0.9, 1.0};
constexpr double kNearDiameters = 1.05;  // classes nearer than this are one
constexpr double kMostCut = 0.5;         // of the volume
constexpr double kCutStep = 0.05;

/// All particles of one PBM class in one compartment.
struct Share {
  std::size_t compartment = 0;
  double number = 0.0;
  double volume = 0.0;  ///< of them all [m^3]

  double particle_volume() const { return volume / number; }
};

/// One DEM size class in real sizes.
struct SizeClass {
  double number = 0.0, volume = 0.0;  ///< represented particles, with their volume [m^3]
  std::vector<double> volume_in;      ///< what it stands for in each compartment, tail included [m^3]

  double particle_volume() const { return volume / number; }
  double diameter() const { return sphere_diameter(particle_volume()); }
};

struct Classes {
  std::vector<SizeClass> all;  ///< ascending
  double cut = 0.0;            ///< asked for
  double tail_volume = 0.0, tail_number = 0.0;
  double capped_volume = 0.0;  ///< of particles larger than the machine allows, shown smaller [m^3]

  double represented_volume() const {
    double total = 0.0;
    for (const SizeClass& one : all) total += one.volume;
    return total;
  }

  /// Particles of these sizes that make up the whole volume.
  double particles() const {
    double total = 0.0;
    for (const SizeClass& one : all)
      total += std::accumulate(one.volume_in.begin(), one.volume_in.end(), 0.0) / one.particle_volume();
    return total;
  }
};

Status check(const HoldUp& hold_up, const PopulationSettings& settings) {
  const std::size_t n_1 = hold_up.solid_1.size(), n_2 = hold_up.solid_2.size(), n_x = hold_up.n_compartments();
  if (settings.compartment_edge.size() != n_x + 1)
    return Error{fmt::format("the PBM has {} compartments, the DEM has {}: they must be the same compartments.", n_x,
                             settings.compartment_edge.empty() ? 0 : settings.compartment_edge.size() - 1)};
  if (settings.budget < 1)
    return Error{fmt::format("the DEM's particle budget is {}; it must be >= 1.", settings.budget)};
  if (settings.size_classes < 1)
    return Error{fmt::format("the number of DEM size classes is {}; it must be >= 1.", settings.size_classes)};
  if (hold_up.liquid.size() != n_x || hold_up.gas.size() != n_x)
    return Error{"the PBM state has number, liquid and gas of different shapes."};
  for (std::size_t x = 0; x < n_x; ++x)
    for (const auto& [what, table] :
         {std::pair{"number", &hold_up.number[x]}, {"liquid", &hold_up.liquid[x]}, {"gas", &hold_up.gas[x]}}) {
      if (table->size() != n_1) return Error{"the PBM state does not have the shape of its grid."};
      for (std::size_t i = 0; i < n_1; ++i) {
        if ((*table)[i].size() != n_2) return Error{"the PBM state does not have the shape of its grid."};
        for (std::size_t j = 0; j < n_2; ++j)
          if (!((*table)[i][j] >= 0.0) || !std::isfinite((*table)[i][j]))
            return Error{fmt::format(
                "the PBM state at {:.6g} s has {} = {} in compartment {}, class ({}, {}); it must be a number >= 0.",
                hold_up.time, what, (*table)[i][j], x + 1, i + 1, j + 1)};
      }
    }
  return {};
}

/// Everything the PBM holds, from fine to coarse.
std::vector<Share> sorted_shares(const HoldUp& hold_up) {
  std::vector<Share> shares;
  for (std::size_t x = 0; x < hold_up.n_compartments(); ++x)
    for (std::size_t i = 0; i < hold_up.solid_1.size(); ++i)
      for (std::size_t j = 0; j < hold_up.solid_2.size(); ++j) {
        const double number = hold_up.number[x][i][j];
        if (!(number > 0.0)) continue;
        shares.push_back(
            {x, number,
             number * (hold_up.solid_1[i] + hold_up.solid_2[j]) + hold_up.liquid[x][i][j] + hold_up.gas[x][i][j]});
      }
  std::stable_sort(shares.begin(), shares.end(),
                   [](const Share& a, const Share& b) { return a.particle_volume() < b.particle_volume(); });
  return shares;
}

void merge(SizeClass& into, const SizeClass& other) {
  into.number += other.number;
  into.volume += other.volume;
  for (std::size_t x = 0; x < into.volume_in.size(); ++x) into.volume_in[x] += other.volume_in[x];
}

/// The tail of the finest `cut` of the volume is set apart; the rest is split where equal shares of volume end.
Classes classify(const std::vector<Share>& shares, std::size_t n_compartments, int n_classes, double cut) {
  double total = 0.0;
  for (const Share& share : shares) total += share.volume;
  Classes classes;
  classes.cut = cut;
  std::vector<double> tail(n_compartments, 0.0);
  std::size_t first = 0;
  for (double below = shares[0].volume; first + 1 < shares.size() && below <= cut * total;
       below += shares[first].volume) {
    tail[shares[first].compartment] += shares[first].volume;
    classes.tail_volume += shares[first].volume;
    classes.tail_number += shares[first].number;
    ++first;
  }

  const SizeClass empty{0.0, 0.0, std::vector<double>(n_compartments, 0.0)};
  std::vector<SizeClass> split(static_cast<std::size_t>(n_classes), empty);
  const double represented = total - classes.tail_volume;
  double below = 0.0;
  for (std::size_t s = first; s < shares.size(); ++s) {
    const Share& share = shares[s];
    const double middle = (below + 0.5 * share.volume) / represented;
    const auto k = static_cast<std::size_t>(std::clamp(static_cast<int>(middle * n_classes), 0, n_classes - 1));
    split[k].number += share.number;
    split[k].volume += share.volume;
    split[k].volume_in[share.compartment] += share.volume;
    below += share.volume;
  }
  for (const SizeClass& one : split) {
    if (!(one.number > 0.0)) continue;
    const bool near = !classes.all.empty() && one.diameter() < kNearDiameters * classes.all.back().diameter();
    if (near)
      merge(classes.all.back(), one);
    else
      classes.all.push_back(one);
  }
  for (std::size_t x = 0; x < n_compartments; ++x) classes.all.front().volume_in[x] += tail[x];
  return classes;
}

/// f that gives so many DEM particles, never below 1.
double coarse_graining_for(const Classes& classes, double particles) {
  return std::max(std::cbrt(classes.particles() / particles), 1.0);
}

bool fits(const Classes& classes, double f, const PopulationSettings& settings) {
  return settings.largest_diameter <= 0.0 || f * classes.all.back().diameter() <= settings.largest_diameter;
}

/// Whole particles. In each compartment the volume a class was rounded by is made up by the next finer one, down to the
/// finest, so the hold-up is right; and each class hands its rounding on to the next compartment, so that a class with
/// a third of a particle everywhere is not lost everywhere.
Counts whole_counts(const Classes& classes, std::size_t n_compartments, double f) {
  const std::size_t n = classes.all.size();
  Counts counts(n_compartments, std::vector<long>(n, 0));
  std::vector<double> owed(n, 0.0);  // particles a class has been rounded down by so far
  for (std::size_t x = 0; x < n_compartments; ++x) {
    double left = 0.0;  // of the hold-up, not yet in particles [m^3]
    std::size_t finest = n;
    for (std::size_t k = n; k-- > 0;) {
      left += classes.all[k].volume_in[x];
      if (classes.all[k].volume_in[x] > 0.0) finest = k;
    }
    double from_coarser = 0.0;  // volume [m^3]
    for (std::size_t k = n; k-- > finest && finest < n;) {
      const double here = classes.all[k].volume_in[x], particle = f * f * f * classes.all[k].particle_volume();
      if (!(here > 0.0)) continue;
      const double wanted = (here + from_coarser) / particle;
      const bool last = k == finest;
      const auto most = last ? std::numeric_limits<long>::max() : static_cast<long>(left / particle);
      const long whole = std::clamp(std::lround(last ? left / particle : wanted + owed[k]), 0L, most);
      owed[k] += wanted - static_cast<double>(whole);
      from_coarser += here - static_cast<double>(whole) * particle;
      counts[x][k] = whole;
      left = std::max(left - static_cast<double>(whole) * particle, 0.0);
    }
  }
  return counts;
}

long total_of(const Counts& counts) {
  long total = 0;
  for (const std::vector<long>& compartment : counts)
    total += std::accumulate(compartment.begin(), compartment.end(), 0L);
  return total;
}

struct Chosen {
  Classes classes;
  double f = 1.0;
  Counts counts;
  std::string choice;
};

/// Where even the widest tail leaves too large particles: classes above the bound are shown at the bound, by more of
/// them. Empty if the bound and the budget exclude each other.
std::optional<Chosen> cap(const Classes& classes, std::size_t n_compartments, const PopulationSettings& settings) {
  if (settings.largest_diameter <= 0.0) return std::nullopt;
  constexpr double kFiner = 1.02;
  const auto capped_at = [&](double f) {
    Classes capped = classes;
    capped.all.clear();
    for (SizeClass one : classes.all) {
      const double largest = sphere_volume(settings.largest_diameter / f);
      if (one.particle_volume() > largest) {
        capped.capped_volume += one.volume;
        one.number = one.volume / largest;
      }
      const bool near = !capped.all.empty() && one.diameter() < kNearDiameters * capped.all.back().diameter();
      near ? merge(capped.all.back(), one) : capped.all.push_back(one);
    }
    return capped;
  };
  for (double f = coarse_graining_for(classes, static_cast<double>(settings.budget));; f *= kFiner) {
    Classes capped = capped_at(f);
    Counts counts = whole_counts(capped, n_compartments, f);
    if (total_of(counts) <= settings.budget) {
      const double share = capped.capped_volume / (capped.represented_volume() + capped.tail_volume);
      return Chosen{
          std::move(capped), f, std::move(counts),
          fmt::format(
              "f = {:.4g}: {:.3g} % of the volume is in particles larger than the machine allows in the DEM, and is "
              "shown by particles of {:.4g} m",
              f, 100.0 * share, settings.largest_diameter)};
    }
    if (capped.all.size() == 1) return std::nullopt;  // all at the bound, and still too many
  }
}

/// f and cut. The budget holds for whole particles: a coarse one rounded down is made up by many fine ones.
Result<Chosen> choose(const std::vector<Share>& shares, std::size_t n_compartments,
                      const PopulationSettings& settings) {
  const auto budget = static_cast<double>(settings.budget);
  const double previous = settings.previous_coarse_graining;
  Classes classes = classify(shares, n_compartments, settings.size_classes, settings.fine_cut);
  if (previous >= 1.0 && fits(classes, previous, settings)) {
    const double particles = classes.particles() / (previous * previous * previous);
    if (particles <= budget && (previous == 1.0 || particles >= 0.5 * budget)) {
      Counts counts = whole_counts(classes, n_compartments, previous);
      if (const long total = total_of(counts); total <= settings.budget)
        return Chosen{std::move(classes), previous, std::move(counts),
                      fmt::format("f = {:.4g} kept: {} particles of at most {}", previous, total, settings.budget)};
    }
  }
  for (const double share : kTriedShares)
    for (double cut = settings.fine_cut; cut <= kMostCut + 1e-12; cut += kCutStep) {
      classes = classify(shares, n_compartments, settings.size_classes, cut);
      const double f = coarse_graining_for(classes, share * budget);
      if (!fits(classes, f, settings)) continue;
      Counts counts = whole_counts(classes, n_compartments, f);
      if (total_of(counts) > settings.budget) break;
      const std::string why =
          cut > settings.fine_cut
              ? fmt::format(
                    "; the finest {:.3g} % of the volume rides on the finest class, so that the largest "
                    "particle stays below {:.4g} m",
                    100.0 * cut, settings.largest_diameter)
              : "";
      return Chosen{std::move(classes), f, std::move(counts),
                    fmt::format("f = {:.4g} chosen for {:.3g} of the budget of {}{}", f, share, settings.budget, why)};
    }
  if (auto capped = cap(classes, n_compartments, settings)) return *std::move(capped);
  if (settings.largest_diameter <= 0.0)
    return Error{
        fmt::format("the hold-up of {} compartments cannot be shown with {} whole particles. Raise the particle budget "
                    "(/dem/particles).",
                    n_compartments, settings.budget)};
  const double needed = classes.particles() * std::pow(classes.all.back().diameter() / settings.largest_diameter, 3);
  return Error{fmt::format(
      "the hold-up cannot be shown with {} particles of at most {:.4g} m: that takes about {:.0f}. Raise the "
      "particle budget (/dem/particles) or allow larger ones.",
      settings.budget, settings.largest_diameter, std::ceil(needed))};
}

/// Half-way (in log d) between neighbours; the outer edges mirror the inner ones, so each class's mid is its diameter
/// or near it.
std::vector<double> edges_around(const std::vector<double>& diameter) {
  constexpr double kAlone = 1.25;
  const std::size_t n = diameter.size();
  std::vector<double> edge(n + 1);
  for (std::size_t k = 1; k < n; ++k) edge[k] = std::sqrt(diameter[k - 1] * diameter[k]);
  edge.front() = n > 1 ? diameter.front() * diameter.front() / edge[1] : diameter.front() / kAlone;
  edge.back() = n > 1 ? diameter.back() * diameter.back() / edge[n - 1] : diameter.back() * kAlone;
  return edge;
}

double envelope_density(const HoldUp& hold_up, const PopulationSettings& settings) {
  double mass = 0.0, volume = 0.0;
  for (std::size_t x = 0; x < hold_up.n_compartments(); ++x) {
    volume += hold_up.volume(x);
    for (std::size_t i = 0; i < hold_up.solid_1.size(); ++i)
      for (std::size_t j = 0; j < hold_up.solid_2.size(); ++j)
        mass += hold_up.number[x][i][j] *
                    (hold_up.solid_1[i] * settings.solid_density[0] + hold_up.solid_2[j] * settings.solid_density[1]) +
                hold_up.liquid[x][i][j] * settings.liquid_density;
  }
  return mass / volume;
}

}  // namespace

double HoldUp::volume(std::size_t x) const {
  double total = 0.0;
  for (std::size_t i = 0; i < solid_1.size(); ++i)
    for (std::size_t j = 0; j < solid_2.size(); ++j)
      if (number[x][i][j] > 0.0) total += number[x][i][j] * (solid_1[i] + solid_2[j]) + liquid[x][i][j] + gas[x][i][j];
  return total;
}

Result<SampledPopulation> sample_population(const HoldUp& hold_up, const PopulationSettings& settings) {
  GRANARY_CHECK(check(hold_up, settings));
  const std::size_t n_x = hold_up.n_compartments();
  const std::vector<Share> shares = sorted_shares(hold_up);
  if (shares.empty())
    return Error{
        fmt::format("the PBM holds no particles at {:.6g} s, so the DEM would have nothing to stir. Give it a feed or "
                    "initial classes.",
                    hold_up.time)};
  GRANARY_TRY(const Chosen chosen, choose(shares, n_x, settings));
  const Classes& classes = chosen.classes;

  SampledPopulation out;
  out.coarse_graining = chosen.f;
  out.coarse_graining_changed =
      settings.previous_coarse_graining > 0.0 && chosen.f != settings.previous_coarse_graining;
  out.choice = chosen.choice;
  for (const SizeClass& one : classes.all) out.class_diameter.push_back(chosen.f * one.diameter());
  out.class_edge = edges_around(out.class_diameter);
  out.density = envelope_density(hold_up, settings);

  const Counts& counts = chosen.counts;
  double made = 0.0, real_particles = 0.0;
  for (std::size_t x = 0; x < n_x; ++x) {
    out.volume += hold_up.volume(x);
    out.compartments.push_back(
        {settings.compartment_edge[x], settings.compartment_edge[x + 1], out.class_diameter, counts[x]});
    for (std::size_t k = 0; k < counts[x].size(); ++k) {
      out.total += counts[x][k];
      made += static_cast<double>(counts[x][k]) * sphere_volume(out.class_diameter[k]);
    }
  }
  if (out.total == 0)
    return Error{
        fmt::format("the hold-up of {:.4g} m^3 is less than one DEM particle of {:.4g} m. Raise the particle budget "
                    "(/dem/particles).",
                    out.volume, out.class_diameter.front())};
  for (const Share& share : shares) real_particles += share.number;
  out.volume_error = std::abs(made - out.volume) / out.volume;
  out.unrepresented_volume = classes.tail_volume / out.volume;
  out.capped_volume = classes.capped_volume / out.volume;
  out.unrepresented_number = classes.tail_number / real_particles;
  return out;
}

Result<HoldUp> starting_hold_up(const pbm::PbmCase& pbm_case) {
  const auto n_1 = static_cast<std::size_t>(pbm_case.grid.bins[0]),
             n_2 = static_cast<std::size_t>(pbm_case.grid.bins[1]);
  const auto n_x = static_cast<std::size_t>(pbm_case.compartments.count);
  const auto pivots = [&](std::size_t component, std::size_t n) {
    std::vector<double> pivot(n);
    for (std::size_t i = 0; i < n; ++i)
      pivot[i] = pbm_case.grid.smallest[component] * std::pow(pbm_case.grid.ratio[component], static_cast<double>(i));
    return pivot;
  };
  const Matrix none(n_1, std::vector<double>(n_2, 0.0));
  HoldUp hold_up{pbm_case.start_time,
                 pivots(0, n_1),
                 pivots(1, n_2),
                 std::vector<Matrix>(n_x, none),
                 std::vector<Matrix>(n_x, none),
                 std::vector<Matrix>(n_x, none)};
  const auto inside = [&](int i, int j) {
    return i >= 0 && j >= 0 && static_cast<std::size_t>(i) < n_1 && static_cast<std::size_t>(j) < n_2;
  };

  for (const pbm::InitialClass& initial : pbm_case.initial) {
    if (!inside(initial.i, initial.j) || initial.compartment >= static_cast<int>(n_x))
      return Error{fmt::format("the initial class ({}, {}) of compartment {} is not on the PBM's grid.", initial.i,
                               initial.j, initial.compartment)};
    for (std::size_t x = 0; x < n_x; ++x) {
      if (initial.compartment >= 0 && static_cast<std::size_t>(initial.compartment) != x) continue;
      const auto i = static_cast<std::size_t>(initial.i), j = static_cast<std::size_t>(initial.j);
      hold_up.number[x][i][j] += initial.number;
      hold_up.liquid[x][i][j] += initial.liquid;
      hold_up.gas[x][i][j] += initial.gas;
    }
  }
  if (!pbm_case.initial.empty()) return hold_up;

  if (!pbm_case.feed || !pbm_case.compartments.residence_time)
    return Error{
        "the process starts empty and nothing flows in, so the first DEM burst would have nothing to stir. Give the "
        "PBM initial classes "
        "(/charge), or a feed (/feed) and a residence time (/process/residence_time)."};
  const double stay = *pbm_case.compartments.residence_time / static_cast<double>(n_x);
  const double gas_per_solid = pbm_case.feed->porosity / (1.0 - pbm_case.feed->porosity);
  for (const pbm::ClassRate& fed : pbm_case.feed->classes) {
    if (!inside(fed.i, fed.j))
      return Error{fmt::format("the feed's class ({}, {}) is not on the PBM's grid.", fed.i, fed.j)};
    const auto i = static_cast<std::size_t>(fed.i), j = static_cast<std::size_t>(fed.j);
    for (std::size_t x = 0; x < n_x; ++x) {
      hold_up.number[x][i][j] += fed.rate * stay;
      hold_up.gas[x][i][j] += fed.rate * stay * (hold_up.solid_1[i] + hold_up.solid_2[j]) * gas_per_solid;
    }
  }
  return hold_up;
}

PbmSummary summarize(const HoldUp& hold_up) {
  PbmSummary summary;
  summary.time = hold_up.time;
  for (std::size_t x = 0; x < hold_up.n_compartments(); ++x) {
    std::vector<double> diameter, volume;
    double number = 0.0;
    for (std::size_t i = 0; i < hold_up.solid_1.size(); ++i)
      for (std::size_t j = 0; j < hold_up.solid_2.size(); ++j) {
        const double here = hold_up.number[x][i][j];
        if (!(here > 0.0)) continue;
        number += here;
        volume.push_back(here * (hold_up.solid_1[i] + hold_up.solid_2[j]) + hold_up.liquid[x][i][j] +
                         hold_up.gas[x][i][j]);
        diameter.push_back(sphere_diameter(volume.back() / here));
      }
    summary.d50.push_back(quantile(diameter, volume, 0.5, log_width_of_pivots(hold_up.solid_1, hold_up.solid_2)));
    summary.number.push_back(number);
  }
  return summary;
}

json::Value to_json(const SampledPopulation& sampled) {
  json::Value counts = json::Value::array();
  for (const dem::Population& compartment : sampled.compartments) {
    json::Value row = json::Value::array();
    for (const long count : compartment.count) row.push(std::int64_t{count});
    counts.push(std::move(row));
  }
  return json::Value::object({{"coarse_graining", sampled.coarse_graining},
                              {"coarse_graining_changed", sampled.coarse_graining_changed},
                              {"total", std::int64_t{sampled.total}},
                              {"class_diameter_m", sampled.class_diameter},
                              {"counts", std::move(counts)},
                              {"density_kg_m3", sampled.density},
                              {"volume_m3", sampled.volume},
                              {"volume_error", sampled.volume_error},
                              {"unrepresented_volume", sampled.unrepresented_volume},
                              {"unrepresented_number", sampled.unrepresented_number},
                              {"capped_volume", sampled.capped_volume},
                              {"choice", sampled.choice}});
}

}  // namespace granary::coupling
