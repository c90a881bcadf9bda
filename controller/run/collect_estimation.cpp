#include "controller/run/collect_estimation.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/json/io.hpp"

namespace granary::run {
namespace fs = std::filesystem;
using campaign::Estimation;

namespace {

std::string name_of(const estimation::Target& target) {
  const std::string where = target.compartment == estimation::kOutlet ? "outlet"
                            : target.compartment == estimation::kEverywhere
                                ? "all"
                                : fmt::format("compartment {}", target.compartment + 1);
  return fmt::format("{}, {}", estimation::name_of(target.quantity), where);
}

void read_parameters(EstimationSummary& summary, const Estimation& estimation, const json::Value& best) {
  const auto& found = best["parameters"].items_or_none();
  for (std::size_t k = 0; k < estimation.parameters.size(); ++k) {
    const auto& of = estimation.parameters[k];
    const json::Value known = k < found.size() ? found[k] : json::Value::object();
    summary.parameters.push_back({of.is.name, of.key, of.unit, of.is.low, of.is.high, of.is.start.value_or(kNone),
                                  known.number_or("value", kNone), known.number_or("low", kNone),
                                  known.number_or("high", kNone)});
  }
  const std::size_t n = estimation.parameters.size();
  const auto& rows = best["correlation"].items_or_none();
  for (std::size_t k = 0; k < n; ++k) {
    std::vector<double> row = k < rows.size() ? rows[k].numbers() : std::vector<double>();
    row.resize(n, kNone);
    summary.correlation.push_back(std::move(row));
  }
}

/// Each number of each target beside what the best trial gives for it.
void read_data(EstimationSummary& summary, const Estimation& estimation, const std::vector<double>& model) {
  std::size_t at = 0;
  const auto next = [&] { return at < model.size() ? model[at++] : kNone; };
  for (std::size_t k = 0; k < estimation.targets.size(); ++k) {
    const estimation::Target& target = estimation.targets[k];
    const std::int64_t held_out = target.held_out ? 1 : 0;
    const std::string unit = campaign::unit_of(target.quantity, target.compartment);
    if (target.quantity != estimation::Quantity::distribution) {
      summary.data.push_back({name_of(target), unit, target.time, target.value, target.error, next(), held_out});
      continue;
    }
    for (std::size_t i = 0; i < target.shares.size(); ++i)
      summary.data.push_back({fmt::format("share {:.4g} to {:.4g} um, {}", 1e6 * target.edges[i],
                                          1e6 * target.edges[i + 1], name_of(target)),
                              "1", target.time, target.shares[i], target.error, next(), held_out});
  }
}

Status read_evaluations(EstimationSummary& summary, const fs::path& file) {
  GRANARY_TRY(const auto lines, json::LineReader(file).next());
  for (const json::Value& line : lines) {
    if (line.find("trial") == nullptr) continue;
    summary.time.push_back(line.number_or("time_s", kNone));
    summary.cost.push_back(line["cost"].is_number() ? line["cost"].as_number() : kNone);
    summary.version.push_back(line.integer_or("version", 1));
  }
  return {};
}

/// The folders of the final run; by itself (no DEM) an estimation has it as its only burst.
std::vector<fs::path> final_run(const fs::path& dir) {
  const fs::path alone = dir / "bursts/0001-pbm";
  if (fs::exists(alone) && !fs::exists(dir / "bursts/0001-dem")) return {alone};
  std::vector<fs::path> folders;
  for (int k = 1; fs::exists(dir / "final" / fmt::format("{:04}", k)); ++k)
    folders.push_back(dir / "final" / fmt::format("{:04}", k));
  return folders;
}

/// The outlet over the final run, its segments joined.
Status read_final_run(EstimationSummary& summary, const fs::path& dir) {
  for (const fs::path& folder : final_run(dir)) {
    GRANARY_TRY(const auto lines, json::LineReader(folder / "progress.jsonl").next());
    for (const json::Value& line : lines) {
      if (!line["time_s"].is_number()) continue;
      summary.final_time.push_back(line["time_s"].as_number());
      summary.final_d10.push_back(line["outlet"].number_or("d10_m", kNone));
      summary.final_d50.push_back(line["outlet"].number_or("d50_m", kNone));
      summary.final_d90.push_back(line["outlet"].number_or("d90_m", kNone));
    }
  }
  return {};
}

}  // namespace

Result<EstimationSummary> estimation_of(const campaign::Campaign& campaign, const fs::path& dir,
                                        const std::vector<pilot::Record>& journal, const CoreUse& use) {
  EstimationSummary summary;
  const fs::path folder = dir / "estimation";
  json::Value best = json::Value::object();
  if (fs::exists(folder / "best.json")) {
    GRANARY_TRY(best, json::read_file(folder / "best.json"));
  }
  read_parameters(summary, *campaign.estimation, best);
  read_data(summary, *campaign.estimation, best.numbers("model"));
  if (fs::exists(folder / "evaluations.jsonl")) GRANARY_CHECK(read_evaluations(summary, folder / "evaluations.jsonl"));
  GRANARY_CHECK(read_final_run(summary, dir));
  if (best.find("intervals") != nullptr && !best["from_posterior"].as_bool() && best["parameters"].size() > 0)
    summary.warnings.push_back("95 % intervals: " + best.text_or("intervals", "") + ".");
  for (const char* kind : {"unidentified", "doubts"})
    for (const json::Value& warning : best[kind].items_or_none())
      if (warning.is_string()) summary.warnings.push_back(warning.as_string());
  summary.phase = best.text_or("phase", "search");
  summary.misfit = best.number_or("chi_square_per_datum", kNone);
  summary.held_out = best.number_or("held_out_mean_square", kNone);
  summary.coupled_wall = use.wall;
  for (const pilot::Record& record : journal) {
    if (record.kind == "estimation.over") summary.coupled_wall = record.payload.number_or("time_s", use.wall);
    if (record.kind != "estimation.adopted") continue;
    summary.adopted_by.push_back(record.payload.text_or("burst", ""));
    summary.adopted_time.push_back(record.payload.number_or("time_s", kNone));
    summary.adopted.push_back(record.payload.numbers("values"));
  }
  for (const KindUse& kind : use.kinds)
    if (kind.kind == "estimation") summary.used = kind.core_seconds;
  summary.left = std::max(0.0, (1.0 - use.busy_share) * static_cast<double>(use.cores) * use.wall);
  return summary;
}

}  // namespace granary::run
