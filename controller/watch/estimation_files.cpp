#include "controller/watch/estimation_files.hpp"

#include <algorithm>

namespace granary::watch {

EstimationFiles::EstimationFiles(const std::filesystem::path& dir)
    : best_(dir / "estimation" / "best.json"), evaluations_(dir / "estimation" / "evaluations.jsonl") {}

std::optional<Fit> EstimationFiles::look(const json::Value& understood) {
  // A damaged line is the campaign's affair: what was read before it is shown.
  if (const auto lines = evaluations_.next())
    for (const json::Value& line : *lines) {
      if (line.find("trial") == nullptr) continue;
      ++fit_.evaluations;
      const json::Value& cost = line["cost"];
      if (!cost.is_number()) continue;
      const std::int64_t version = line.integer_or("version", 1);
      const bool begins_anew = version != version_ || fit_.points.empty();
      version_ = version;
      const double best = begins_anew ? cost.as_number() : std::min(cost.as_number(), fit_.points.back().cost);
      fit_.points.push_back({line.number_or("time_s", 0.0), best});
    }
  if (fit_.points.empty()) return std::nullopt;
  if (const auto best = json::read_file(best_)) {
    fit_.phase = best->text_or("phase", "");
    fit_.misfit = best->number_or("chi_square_per_datum", kUnknown);
    fit_.held_out = best->number_or("held_out_mean_square", kUnknown);
    fit_.parameters.clear();
    const auto& units = understood["parameters"].items_or_none();
    for (const json::Value& one : (*best)["parameters"].items_or_none()) {
      const std::size_t k = fit_.parameters.size();
      fit_.parameters.push_back({one.text_or("name", "?"), k < units.size() ? units[k].text_or("unit", "1") : "1",
                                 one.number_or("value", kUnknown), one.number_or("low", kUnknown),
                                 one.number_or("high", kUnknown)});
    }
  }
  return fit_;
}

}  // namespace granary::watch
