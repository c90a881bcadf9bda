#include "controller/report/comparison.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "common/json/io.hpp"
#include "controller/report/script.hpp"

namespace granary::report {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Where a time lies in an ascending list: between rows i and i + 1, at `share` of the way.
struct Place {
  std::size_t i = 0;
  double share = 0.0;
};

Place place_of(const std::vector<double>& time, double t) {
  if (time.size() < 2) return {};
  const auto above = std::upper_bound(time.begin(), time.end(), t);
  const std::size_t i = std::min<std::size_t>(above == time.begin() ? 0 : above - time.begin() - 1, time.size() - 2);
  const double step = time[i + 1] - time[i];
  return {i, step > 0.0 ? std::clamp((t - time[i]) / step, 0.0, 1.0) : 1.0};
}

double at(const std::vector<double>& values, const Place& place) {
  if (place.i >= values.size()) return kNaN;
  if (place.i + 1 == values.size()) return values[place.i];
  return values[place.i] + place.share * (values[place.i + 1] - values[place.i]);
}

/// A row of a table between two of its rows.
std::vector<double> at(const Rows& rows, const Place& place) {
  std::vector<double> row = rows[place.i];
  if (place.i + 1 < rows.size())
    for (std::size_t x = 0; x < row.size(); ++x) row[x] += place.share * (rows[place.i + 1][x] - row[x]);
  return row;
}

Difference difference(const PbmSeries& reference, const Rows& wanted, const PbmSeries& other, const Rows& got,
                      double until) {
  if (wanted.front().size() != got.front().size()) return {kNaN, kNaN};
  Difference d;
  std::size_t n = 0;
  for (std::size_t t = 0; t < reference.time.size() && reference.time[t] <= until; ++t) {
    const std::vector<double> row = at(got, place_of(other.time, reference.time[t]));
    for (std::size_t x = 0; x < row.size(); ++x) {
      const double relative = std::abs(row[x] - wanted[t][x]) / std::abs(wanted[t][x]);
      if (!std::isfinite(relative)) continue;  // an empty compartment
      d.mean += relative;
      d.largest = std::max(d.largest, relative);
      ++n;
    }
  }
  return n == 0 ? Difference{kNaN, kNaN} : Difference{d.mean / static_cast<double>(n), d.largest};
}

/// Mean over the DEM's windows of a rate per particle.
double per_particle(const DemSeries& dem, const std::function<double(std::size_t)>& rate) {
  double sum = 0.0;
  std::size_t n = 0;
  for (std::size_t w = 0; w < dem.time.size(); ++w)
    if (dem.particles[w] > 0.0) sum += rate(w) / dem.particles[w], ++n;
  return n == 0 ? kNaN : sum / static_cast<double>(n);
}

void differing(const std::string& pointer, const json::Value& a, const json::Value& b, std::vector<std::string>& out) {
  if (a == b) return;
  if (!a.is_object() || !b.is_object()) {
    const auto text = [](const json::Value& v) { return v.is_null() ? std::string("(not given)") : json::dump(v); };
    out.push_back(fmt::format("{} {} -> {}", pointer, text(a), text(b)));
    return;
  }
  for (const auto& [key, value] : a.members()) differing(pointer + "/" + key, value, b[key], out);
  static const json::Value kNone;
  for (const auto& [key, value] : b.members())
    if (a.find(key) == nullptr) differing(pointer + "/" + key, kNone, value, out);
}

json::Value workflow_of(const CampaignResults& results) {
  const auto campaign = json::parse(results.provenance.campaign_json, "campaign.json");
  if (!campaign) return json::Value::object();
  return (*campaign)["workflow"];
}

Compared compared(const NamedResults& run, const NamedResults& reference, double time) {
  const CampaignResults& r = run.results;
  const PbmSeries &pbm = r.pbm, &wanted = reference.results.pbm;
  const Place place = place_of(pbm.time, time);
  const std::vector<double> numbers = at(pbm.number, place);
  Compared c{
      .name = run.name,
      .settings = differing_settings(workflow_of(reference.results), workflow_of(r)),
      .ended = r.ended,
      .process_end = pbm.time.back(),
      .wall = r.core_use.wall,
      .outlet_d10 = at(pbm.outlet_d10, place),
      .outlet_d50 = at(pbm.outlet_d50, place),
      .outlet_d90 = at(pbm.outlet_d90, place),
      .number = std::accumulate(numbers.begin(), numbers.end(), 0.0),
      .collisions = per_particle(r.dem, [&](std::size_t w) { return 2.0 * r.dem.collisions[w]; }),
      .impacts = per_particle(
          r.dem, [&](std::size_t w) { return std::accumulate(r.dem.impacts[w].begin(), r.dem.impacts[w].end(), 0.0); }),
      .d50 = difference(wanted, wanted.d50, pbm, pbm.d50, time),
      .number_of_compartments = difference(wanted, wanted.number, pbm, pbm.number, time)};
  for (const KindUse& use : r.core_use.kinds) c.core_seconds += use.core_seconds;
  for (const BurstSummary& burst : r.bursts) ++(burst.kind == "dem" ? c.dem_bursts : c.pbm_bursts);
  return c;
}

/// "54.8 um (-1.2 %)"
std::string beside(const std::string& text, double value, double reference, bool is_reference) {
  if (!std::isfinite(value)) return "-";
  if (is_reference || !(reference != 0.0)) return text;
  return fmt::format("{} ({:+.1f} %)", text, 100.0 * (value / reference - 1.0));
}

}  // namespace

std::vector<std::string> differing_settings(const json::Value& reference, const json::Value& other) {
  std::vector<std::string> out;
  differing("", reference, other, out);
  std::erase_if(out, [](const std::string& line) {
    return line.starts_with("/name ") || line.starts_with("/description ") || line.starts_with("/$schema ");
  });
  return out;
}

Result<Comparison> compare(const std::vector<NamedResults>& runs, double at) {
  if (runs.size() < 2) return Error{"Comparing takes two campaigns at least, the first is the reference."};
  double first_end = std::numeric_limits<double>::infinity();
  std::vector<std::string> problems;
  for (const NamedResults& run : runs) {
    if (run.results.pbm.time.empty()) {
      problems.push_back(fmt::format("{}: its results hold no PBM series.", run.name));
      continue;
    }
    const double end = run.results.pbm.time.back();
    first_end = std::min(first_end, end);
    if (at > end)
      problems.push_back(
          fmt::format("{}: it ended at {:g} s, before {:g} s; take --at {:g} or less.", run.name, end, at, end));
  }
  if (!problems.empty()) return Error{fmt::format("{}", fmt::join(problems, "\n"))};
  Comparison comparison{std::isnan(at) ? first_end : at, {}};
  for (const NamedResults& run : runs) comparison.runs.push_back(compared(run, runs.front(), comparison.at));
  return comparison;
}

std::string table(const Comparison& comparison) {
  const Compared& reference = comparison.runs.front();
  std::size_t width = 4;
  for (const Compared& run : comparison.runs) width = std::max(width, run.name.size());
  std::string out = fmt::format("at {:g} s of the process; in brackets: beside {}\n\n", comparison.at, reference.name);
  out += fmt::format("{:<{}}  {:>18} {:>18} {:>20} {:>18} {:>16}  {:>15} {:>15}  {:>20} {:>16}\n", "run", width,
                     "outlet d50", "d90", "particles", "collisions 1/s", "impacts 1/s", "d50, all times", "number",
                     "wall s", "ended");
  for (const Compared& run : comparison.runs) {
    const bool first = &run == &reference;
    const auto um = [&](double d, double r) { return beside(fmt::format("{:.1f} um", 1e6 * d), d, r, first); };
    const auto apart = [&](const Difference& d) {
      if (first || !std::isfinite(d.mean)) return std::string("-");
      return fmt::format("{:.1f} (<= {:.0f}) %", 100.0 * d.mean, 100.0 * d.largest);
    };
    out += fmt::format("{:<{}}  {:>18} {:>18} {:>20} {:>18} {:>16}  {:>15} {:>15}  {:>20} {:>16}\n", run.name, width,
                       um(run.outlet_d50, reference.outlet_d50), um(run.outlet_d90, reference.outlet_d90),
                       beside(fmt::format("{:.3e}", run.number), run.number, reference.number, first),
                       beside(fmt::format("{:.0f}", run.collisions), run.collisions, reference.collisions, first),
                       beside(fmt::format("{:.1f}", run.impacts), run.impacts, reference.impacts, first),
                       apart(run.d50), apart(run.number_of_compartments),
                       beside(fmt::format("{:.1f}", run.wall), run.wall, reference.wall, first),
                       fmt::format("{} {:.0f} s", run.ended, run.process_end));
  }
  out += "\n\"d50, all times\" and \"number\": mean (and largest) difference over compartments and times.\n";
  for (const Compared& run : comparison.runs)
    if (&run != &reference)
      out += fmt::format("{}: {}\n", run.name,
                         run.settings.empty() ? "the same settings" : fmt::format("{}", fmt::join(run.settings, "; ")));
  return out;
}

json::Value to_json(const Comparison& comparison) {
  json::Value runs = json::Value::array();
  const auto apart = [](const Difference& d) {
    return json::Value::object({{"mean", d.mean}, {"largest", d.largest}});
  };
  for (const Compared& run : comparison.runs)
    runs.push(json::Value::object({{"name", run.name},
                                   {"settings", run.settings},
                                   {"ended", run.ended},
                                   {"process_end_s", run.process_end},
                                   {"wall_s", run.wall},
                                   {"core_s", run.core_seconds},
                                   {"dem_bursts", run.dem_bursts},
                                   {"pbm_bursts", run.pbm_bursts},
                                   {"outlet_d10_m", run.outlet_d10},
                                   {"outlet_d50_m", run.outlet_d50},
                                   {"outlet_d90_m", run.outlet_d90},
                                   {"number", run.number},
                                   {"collisions_per_particle_s", run.collisions},
                                   {"impacts_per_particle_s", run.impacts},
                                   {"d50_difference", apart(run.d50)},
                                   {"number_difference", apart(run.number_of_compartments)}}));
  return json::Value::object({{"at_s", comparison.at}, {"runs", std::move(runs)}});
}

Plot outlet_plot(const std::vector<NamedResults>& runs) {
  const std::vector<double>* longest = nullptr;
  double largest = 0.0;
  for (const NamedResults& run : runs) {
    const PbmSeries& pbm = run.results.pbm;
    if (longest == nullptr || pbm.time.back() > longest->back()) longest = &pbm.time;
    for (const double d : pbm.outlet_d50)
      if (std::isfinite(d)) largest = std::max(largest, d);
  }
  const LengthUnit unit = length_unit_for(largest);
  LinePlot plot{.x_title = "process time [s]",
                .y_title = fmt::format("d50 of what flows out [{}]", unit.name),
                .x = *longest,
                .from_zero = false};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const PbmSeries& pbm = runs[i].results.pbm;
    std::vector<double> line;
    for (const double t : *longest)
      line.push_back(t > pbm.time.back() ? kNaN : at(pbm.outlet_d50, place_of(pbm.time, t)) / unit.metres);
    plot.lines.push_back({shortened(runs[i].name), std::string(category_colour(i)), std::move(line), i > 0});
  }
  return {"outlet", 760, 380, line_plot_script(plot)};
}

}  // namespace granary::report
