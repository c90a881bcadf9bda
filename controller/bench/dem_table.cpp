#include "controller/bench/dem_table.hpp"

#include <fmt/format.h>

namespace granary::bench {
namespace {

using json::Value;

std::string number(const Value& value, fmt::format_string<double> format) {
  return value.is_number() ? fmt::format(format, value.as_number()) : "-";
}

std::string percent(const Value& share) {
  return share.is_number() ? fmt::format("{:.1f} %", 100.0 * share.as_number()) : "-";
}

/// "+1.2 +- 0.8 %"; "-" if it was not measured.
std::string with_error(const Value& row, const char* key, const char* error) {
  if (!row[key].is_number()) return "-";
  return fmt::format("{:+.1f} +- {:.1f} %", 100.0 * row.number_or(key, 0.0), 100.0 * row.number_or(error, 0.0));
}

std::string speed_table(const Value& rows) {
  if (rows.size() == 0) return "";
  std::string text = "Time per step, stock LIGGGHTS with its best skin beside granary-dem, medians\n";
  text +=
      fmt::format("{:<30} {:>9} {:>9} {:>5} {:>6} {:>9} {:>10} {:>7}  {:>17} {:>17} {:>17}\n", "case", "particles",
                  "triangles", "ranks", "skin", "stock", "granary", "ratio", "collisions", "impacts", "impact speed");
  for (const Value& row : rows.items())
    text +=
        fmt::format("{:<30} {:>9} {:>9} {:>5} {:>6} {:>9} {:>10} {:>7}  {:>17} {:>17} {:>17}{}\n",
                    row.text_or("case", ""), row.integer_or("particles", 0), row.integer_or("impeller_triangles", 0),
                    row.integer_or("ranks", 0), number(row["stock_skin_m"], "{:.4f}"),
                    number(row["stock_ms_per_step"], "{:.3f} ms"), number(row["granary_ms_per_step"], "{:.4f} ms"),
                    number(row["ratio"], "{:.1f}x"), with_error(row, "collision_rate_difference", "statistical_error"),
                    with_error(row, "impact_rate_difference", "impact_rate_statistical_error"),
                    with_error(row, "impact_speed_difference", "impact_speed_statistical_error"),
                    row["granary_over_one_rank"].is_number()
                        ? fmt::format("  {:.2f}x one rank", row.number_or("granary_over_one_rank", 0.0))
                        : "");
  return text;
}

std::string overheads_text(const Value& document) {
  const Value &tally = document["tally_overhead"], &restart = document["restart_overhead"],
              &process = document["process"];
  if (!tally.is_object()) return "";
  return fmt::format(
      "\nTally: {} of the pair forces' time, {} of a step\nRestart: {} from the end of a burst to the first step of "
      "the next\n{:g} s of the mixer with its hold-up, {} particles, steps of {:g} us: {} of one core ({})\n",
      percent(tally["share_of_pair_time"]), percent(tally["share_of_step"]), number(restart["seconds"], "{:.2f} s"),
      process.number_or("process_s", 0.0), process.integer_or("particles_at_start", 0),
      1e6 * process.number_or("time_step_s", 0.0), number(process["wall_s"], "{:.0f} s"),
      process["is_extrapolated"] == Value(true)
          ? fmt::format("extrapolated from {:.3g} s", process.number_or("measured_s", 0.0))
          : std::string("all of them run"));
}

std::string comparison_table(const Value& rows) {
  std::string text;
  for (const Value& one : rows.items_or_none()) {
    text +=
        fmt::format("\n{}: stock walls and ours, {} seeds of {:.3g} s each\n{:<20} {:<16} {:>20} {:>20} {:>9} {:>6}\n",
                    one.text_or("case", ""), one.integer_or("seeds", 0), one.number_or("measured_s_each", 0.0),
                    "quantity", "unit", "stock", "granary", "differ", "z");
    for (const Value& row : one["quantities"].items_or_none())
      text += fmt::format(
          "{:<20} {:<16} {:>20} {:>20} {:>9} {:>6.1f}\n", row.text_or("quantity", ""), row.text_or("unit", ""),
          fmt::format("{:.4g} +- {:.2g}", row.number_or("stock", 0.0), row.number_or("stock_error", 0.0)),
          fmt::format("{:.4g} +- {:.2g}", row.number_or("granary", 0.0), row.number_or("granary_error", 0.0)),
          fmt::format("{:+.1f} %", 100.0 * row.number_or("difference", 0.0)), row.number_or("z", 0.0));
    text += fmt::format("largest |z| {:.1f} ({}); chance exceeds {:.1f} once in 1000 comparisons: {}\n",
                        one.number_or("largest_z", 0.0), one.text_or("largest_z_of", ""),
                        one.number_or("allowed_z", 0.0), one["agree"] == Value(true) ? "they agree" : "THEY DIFFER");
  }
  return text;
}

std::string choices_table(const Value& rows) {
  if (rows.size() == 0) return "";
  std::string text = fmt::format(
      "\nSpeed against error: each choice against the first of its kind, statistical error beside it\n"
      "{:<16} {:<26} {:>12} {:>18} {:>18} {:>18}\n",
      "choice", "value", "core s / s", "collision rate", "impact rate", "impact speed");
  for (const Value& row : rows.items())
    text += fmt::format(
        "{:<16} {:<26} {:>12} {:>18} {:>18} {:>18}\n", row.text_or("choice", ""), row.text_or("value", ""),
        number(row["core_s_per_process_s"].is_number() ? row["core_s_per_process_s"] : row["core_s_per_burst"],
               row["core_s_per_burst"].is_number() ? fmt::format_string<double>("{:.2f} s each")
                                                   : fmt::format_string<double>("{:.1f}")),
        with_error(row, "collision_rate_error", "collision_rate_statistical_error"),
        with_error(row, "impact_rate_error", "impact_rate_statistical_error"),
        with_error(row, "impact_speed_error", "impact_speed_statistical_error"));
  return text;
}

}  // namespace

std::string dem_table(const Value& document) {
  return speed_table(document["speed"]) + overheads_text(document) + comparison_table(document["comparison"]) +
         choices_table(document["choices"]) +
         fmt::format("\nLoad of the machine: {:.1f} at the start, {:.1f} at the end; {} cores\n",
                     document.number_or("load_at_start", 0.0), document.number_or("load_at_end", 0.0),
                     document.integer_or("cores", 0));
}

}  // namespace granary::bench
