#include "controller/bench/pbm_table.hpp"

#include <fmt/format.h>

namespace granary::bench {
namespace {

using json::Value;

std::string number_text(const Value& value, fmt::format_string<double> format) {
  return value.is_number() ? fmt::format(format, value.as_number()) : "-";
}

std::string rhs_table(const Value& document) {
  std::string text = "One right-hand side, one core (bins x bins x compartments)\n";
  text += fmt::format("{:<10} {:>7}  {:<22} {:>10} {:>10} {:>8} {:>10} {:>8}   {}\n", "grid", "classes", "kernel",
                      "solver", "reference", "ratio", "bisecting", "ratio", "how the reference was timed");
  for (const Value& row : document["rhs"].items_or_none())
    text += fmt::format("{:<10} {:>7}  {:<22} {:>10} {:>10} {:>8} {:>10} {:>8}   {}\n", row.text_or("grid", ""),
                        row.integer_or("classes", 0), row.text_or("kernel", ""), duration_text(row["solver_s"]),
                        duration_text(row["reference_s"]), number_text(row["ratio"], "{:.1f}x"),
                        duration_text(row["bisecting_reference_s"]), number_text(row["ratio_to_bisecting"], "{:.1f}x"),
                        row.find("kernel_refresh_s") == nullptr
                            ? row.text_or("reference_how", "")
                            : fmt::format("none; the kernel anew: {}", duration_text(row["kernel_refresh_s"])));
  return text;
}

std::string work_precision_table(const Value& document) {
  std::string text =
      "\nError against CPU time: constant kernel, degree of aggregation 0.8, 16 octaves, one compartment\n";
  text += fmt::format("{:<10} {:>5} {:>10} {:>8} {:>10} {:>10}\n", "method", "bins", "tolerance", "rhs", "cpu",
                      "L1 number");
  for (const Value& row : document["work_precision"].items_or_none())
    text +=
        fmt::format("{:<10} {:>5} {:>10g} {:>8} {:>10} {:>10}\n", row.text_or("method", ""), row.integer_or("bins", 0),
                    row.number_or("tolerance", 0.0), row.integer_or("rhs_evaluations", 0), duration_text(row["cpu_s"]),
                    fmt::format("{:.2f} %", 100.0 * row.number_or("l1_number", 0.0)));
  for (const Value& row : document["work_precision_left_out"].items_or_none())
    text += fmt::format("{:<10} {:>5} {:>10g} left out: {}\n", row.text_or("method", ""), row.integer_or("bins", 0),
                        row.number_or("tolerance", 0.0), row.text_or("why", ""));
  text += "\nSpeed-up at equal error\n";
  for (const Value& row : document["speedup_at_error"].items_or_none())
    text += fmt::format("{:>7.3g} %  {}{:>8}  {:>10} {:>10}   {}\n", 100.0 * row.number_or("error", 0.0),
                        row["is_lower_bound"] == Value(true) ? ">= " : "   ", number_text(row["ratio"], "{:.0f}x"),
                        duration_text(row["solver_s"]), duration_text(row["reference_s"]), row.text_or("how", ""));
  return text;
}

std::string temporal_table(const Value& document) {
  std::string text = "\nRight-hand sides against the error of the time integration alone\n";
  for (const Value& one : document["temporal"].items_or_none()) {
    text += fmt::format("{}: {} right-hand sides for an error of {:g}{}\n", one.text_or("case", ""),
                        number_text(one["rhs_evaluations"], "{:.0f}"), one.number_or("wanted_error", 0.0),
                        one.find("reference_rhs_evaluations") == nullptr
                            ? ""
                            : fmt::format(" (reference: {})", number_text(one["reference_rhs_evaluations"], "{:.0f}")));
    if (one.find("left_out") != nullptr) text += fmt::format("  left out: {}\n", one.text_or("left_out", ""));
    for (const Value& run : one["runs"].items_or_none())
      text += run.find("left_out") != nullptr
                  ? fmt::format("  {:<10} {:>8g}  left out: {}\n", run.text_or("method", ""),
                                run.number_or("tolerance", 0.0), run.text_or("left_out", ""))
                  : fmt::format("  {:<10} {:>8g}  {:>7} rhs, {:>6} rejected steps, error {:.1e}\n",
                                run.text_or("method", ""), run.number_or("tolerance", 0.0),
                                run.integer_or("rhs_evaluations", 0), run.integer_or("rejected", 0),
                                run.number_or("l1_time_error", 0.0));
  }
  return text;
}

std::string published_line(const Value& row) {
  return fmt::format("\nThe published case (100 s, {}): {} on one core, {} right-hand sides, temporal error {}{}\n",
                     row.text_or("grid", ""), duration_text(row["cpu_s"]),
                     number_text(row["rhs_evaluations"], "{:.0f}"), number_text(row["l1_time_error"], "{:.1e}"),
                     row.find("left_out") == nullptr ? "" : "; left out: " + row.text_or("left_out", ""));
}

std::string efficiency_line(const Value& document, const std::string& name) {
  if (document[name + "_efficiency"].is_null())
    return fmt::format("2 {}: not measured: {}\n", name, document.text_or(name + "_efficiency_why", ""));
  const Value& timings = document[name + "_timings"];
  const auto part = [&](const char* what) {
    return fmt::format("{} -> {}, efficiency {}", duration_text(timings[what]["one_s"]),
                       duration_text(timings[what]["two_s"]), number_text(timings[what]["efficiency"], "{:.2f}"));
  };
  return fmt::format("2 {:<8} in a run {}; right-hand sides alone {}\n", name + ":", part("in_run"), part("rhs_alone"));
}

}  // namespace

std::string duration_text(const Value& seconds) {
  if (!seconds.is_number()) return "-";
  const double s = seconds.as_number();
  if (s < 1e-3) return fmt::format("{:.3g} us", 1e6 * s);
  return s < 1.0 ? fmt::format("{:.3g} ms", 1e3 * s) : fmt::format("{:.3g} s", s);
}

std::string pbm_table(const Value& document) {
  return rhs_table(document) + work_precision_table(document) + temporal_table(document) +
         published_line(document["published_case"]) + "\nWall time per right-hand side, 16x16x16, one worker -> two\n" +
         efficiency_line(document, "threads") + efficiency_line(document, "ranks");
}

}  // namespace granary::bench
