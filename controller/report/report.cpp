#include "controller/report/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "controller/report/estimation_report.hpp"
#include "controller/report/figures.hpp"
#include "controller/report/html.hpp"
#include "controller/report/page.hpp"

namespace granary::report {
namespace {

std::size_t count_bursts(const CampaignResults& r, std::string_view kind) {
  return static_cast<std::size_t>(
      std::count_if(r.bursts.begin(), r.bursts.end(), [&](const auto& burst) { return burst.kind == kind; }));
}

const KindUse* use_of(const CoreUse& use, std::string_view kind) {
  const auto found =
      std::find_if(use.kinds.begin(), use.kinds.end(), [&](const auto& one) { return one.kind == kind; });
  return found == use.kinds.end() ? nullptr : &*found;
}

std::string kind_name(const std::string& kind) {
  if (kind == "dem") return "DEM";
  if (kind == "pbm") return "PBM";
  return kind;
}

/// "43.1 → 88.2 µm", "310 µm → 1.2 mm"
std::string change_of_d50(const CampaignResults& r) {
  double first = 0.0, last = 0.0;
  for (const auto& burst : r.bursts) {
    if (!(burst.d50 > 0.0)) continue;
    if (first == 0.0) first = burst.d50;
    last = burst.d50;
  }
  if (first == 0.0) return "–";
  std::string from = diameter(first);
  const std::string to = diameter(last), unit = to.substr(to.find(' '));
  if (from.ends_with(unit)) from.resize(from.size() - unit.size());
  return from + " → " + to;
}

std::string cards(const CampaignResults& r) {
  const auto seconds = [&](std::string_view kind) {
    const KindUse* use = use_of(r.core_use, kind);
    return use == nullptr ? std::string("0 s") : duration(use->wall);
  };
  double process = 0.0;
  for (const auto& burst : r.bursts) process = std::max(process, burst.process_end);
  std::string out = "<div class=\"cards\">\n";
  out += card(fmt::format("{} + {}", count_bursts(r, "dem"), count_bursts(r, "pbm")), "DEM and PBM bursts");
  out += card(duration(process), "of the process");
  out += card(change_of_d50(r), "d50, first to last burst");
  out += card(duration(r.core_use.wall), "wall time");
  out += card(seconds("dem"), "with DEM running");
  out += card(seconds("pbm"), "with PBM running");
  out += card(duration(r.core_use.idle), "with nothing running");
  out += card(percent(r.core_use.busy_share),
              fmt::format("core use, {} core{}", r.core_use.cores, r.core_use.cores == 1 ? "" : "s"));
  return out + "</div>\n";
}

std::string bursts_table(const CampaignResults& r) {
  if (r.bursts.empty()) return soft("No burst came to its end.");
  std::vector<std::vector<std::string>> rows;
  for (const auto& b : r.bursts) {
    const bool dem = b.kind == "dem";
    rows.push_back({std::to_string(b.number), kind_name(b.kind),
                    b.reason + (b.exit_code == 0 ? "" : fmt::format(" (exit code {})", b.exit_code)),
                    dem ? fmt::format("{:.4g} → {:.4g} s", b.dem_start, b.dem_end)
                        : fmt::format("{:.4g} → {:.4g} s", b.process_start, b.process_end),
                    duration(b.wall), std::to_string(b.cores), diameter(b.d50), number(b.particles),
                    dem ? number(b.dem_particles) : "–", dem ? number(b.coarse_graining) : "–"});
  }
  return table({{"#", kNumber},
                {"kind"},
                {"why it ended", kProse},
                {"DEM or process clock", kNumber},
                {"wall", kNumber},
                {"cores", kNumber},
                {"d50", kNumber},
                {"particles", kNumber},
                {"DEM particles", kNumber},
                {"coarse-graining", kNumber}},
               rows);
}

std::string core_table(const CoreUse& use) {
  std::vector<std::vector<std::string>> rows;
  const double all = static_cast<double>(use.cores) * use.wall;
  for (const auto& kind : use.kinds)
    rows.push_back({kind_name(kind.kind), duration(kind.wall), number(kind.core_seconds),
                    percent(all > 0.0 ? kind.core_seconds / all : std::nan(""))});
  rows.push_back({"nothing", duration(use.idle), "–", percent(1.0 - use.busy_share) + " idle"});
  return table({{"running"}, {"wall time", kNumber}, {"core seconds", kNumber}, {"of the allocation", kNumber}}, rows);
}

std::string drift_table(const PbmSeries& pbm) {
  if (pbm.time.empty()) return soft("Left out: the results hold no PBM series.");
  const auto row = [&](const char* quantity, const std::vector<double>& drift) {
    double most = std::numeric_limits<double>::quiet_NaN();
    for (const double value : drift)
      if (!std::isnan(value) && !(most >= std::abs(value))) most = std::abs(value);
    return std::vector<std::string>{quantity, number(drift.back()), number(most)};
  };
  return table({{"balance of"}, {"error at the end", kNumber}, {"largest error", kNumber}},
               {row("solid 1", pbm.drift_solid_1), row("solid 2", pbm.drift_solid_2), row("liquid", pbm.drift_liquid),
                row("gas (less what consolidation took)", pbm.drift_gas)}) +
         soft(fmt::format(
             "|hold-up − start − in + out| over what ever was in. {} mm³ of solid left the grid at its top.",
             number(1e9 * pbm.oversize.back())));
}

std::string choices_table(const std::vector<ModelChoice>& choices) {
  if (choices.empty()) return soft("The results hold no list of choices.");
  std::vector<std::vector<std::string>> rows;
  for (const auto& c : choices) rows.push_back({c.choice, c.value, c.error, c.cost});
  return table({{"choice", kProse}, {"taken", kProse}, {"error", kProse}, {"cost", kProse}}, rows);
}

std::string provenance_html(const Provenance& p) {
  std::string out = "<div class=\"two\">\n";
  out += panel(table({{"run"}, {""}}, {{"campaign", p.name},
                                       {"kind", p.kind},
                                       {"machine", p.host},
                                       {"started", p.started},
                                       {"finished", p.finished},
                                       {"Granary", p.version + " (" + p.revision + ")"}}));
  std::vector<std::vector<std::string>> rows;
  for (const auto& version : p.versions) rows.push_back({version.of, version.value});
  for (const auto& seed : p.seeds) rows.push_back({"seed: " + seed.of, std::to_string(seed.value)});
  if (rows.empty()) rows.push_back({"none recorded", ""});
  out += panel(table({{"version or seed"}, {""}}, rows));
  out += "</div>\n";
  if (!p.campaign_json.empty())
    out += panel("<details><summary>Settings: campaign.json as understood (SI units)</summary><pre>" +
                 escaped(p.campaign_json) + "</pre></details>");
  return out;
}

std::vector<Section> sections_of(const CampaignResults& r) {
  std::vector<Section> sections{
      {"bursts", "Bursts, and why each ended", "Bursts", panel(bursts_table(r)), {}},
      {"process", "The granules through the process", "Granules", "", process_figures(r)},
      {"sizes", "Size distributions", "Sizes", "", size_figures(r)},
      {"estimation", "Parameters from data", "Estimation", estimation_html(r), estimation_figures(r)},
      {"rates", "Collisions and impacts", "Collisions", "", rate_figures(r)},
      {"dem", "Inside the DEM", "DEM", "", dem_figures(r)},
      {"cores", "What ran where", "Cores", panel(core_table(r.core_use)), core_figures(r)},
      {"balance", "Conservation", "Conservation", panel(drift_table(r.pbm)), {}},
      {"choices",
       "What was modelled, what was left out, and what each choice is worth",
       "Choices",
       panel(choices_table(r.choices)),
       {}},
      {"provenance", "Provenance", "Provenance", provenance_html(r.provenance), {}}};
  if (r.estimation.parameters.empty())
    std::erase_if(sections, [](const Section& section) { return section.id == "estimation"; });
  return sections;
}

std::string header_html(const CampaignResults& r) {
  const auto& p = r.provenance;
  const std::string badge = r.ended == "steady" || r.ended == "failed" ? r.ended : "other";
  std::string out = fmt::format("<header>\n<h1>{}<span class=\"badge {}\">{}</span></h1>\n",
                                escaped(p.name.empty() ? "Campaign" : p.name), badge,
                                escaped(r.ended.empty() ? "not ended" : r.ended));
  if (!r.message.empty()) out += "<p>" + escaped(r.message) + "</p>\n";
  return out + soft(fmt::format("{} campaign · {} · {} · Granary {}", p.kind, p.started, p.host, p.version)) +
         "</header>\n";
}

}  // namespace

std::vector<Figure> figures_of(const CampaignResults& results) {
  std::vector<Figure> all;
  for (Section& section : sections_of(results))
    std::move(section.figures.begin(), section.figures.end(), std::back_inserter(all));
  return all;
}

Result<std::string> report_html(const CampaignResults& results, Plotter& plotter) {
  return page_html(
      {results.provenance.name + " – Granary report", header_html(results), cards(results), sections_of(results)},
      plotter);
}

}  // namespace granary::report
