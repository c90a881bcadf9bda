#include "controller/report/script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "controller/report/html.hpp"

namespace granary::report {
namespace {

constexpr std::array<std::string_view, 6> kCategories{"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"};

// Viridis at 0, 0.2, ..., 0.8: its light end would vanish on white.
constexpr double kViridis[][3] = {{68, 1, 84}, {65, 68, 135}, {42, 120, 142}, {34, 168, 132}, {122, 209, 81}};

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, std::abs(value));
  return most;
}

/// Rows to draw: all, or evenly spaced ones of long series, with the last and both ends of each stretch. Keeps a page
/// of many lines small.
std::vector<std::size_t> rows_to_draw(std::size_t n_rows, std::size_t n_lines, const std::vector<std::size_t>& breaks) {
  const std::size_t most = std::max<std::size_t>(300, 12000 / std::max<std::size_t>(1, n_lines));
  const std::size_t every = (n_rows + most - 1) / std::max<std::size_t>(1, most);
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < n_rows; ++i) {
    const bool end_of_stretch = i + 1 == n_rows || std::binary_search(breaks.begin(), breaks.end(), i) ||
                                std::binary_search(breaks.begin(), breaks.end(), i + 1);
    if (end_of_stretch || i % every == 0) rows.push_back(i);
  }
  return rows;
}

std::vector<double> chosen(const std::vector<double>& values, const std::vector<std::size_t>& rows) {
  std::vector<double> out;
  for (const auto row : rows)
    out.push_back(row < values.size() ? values[row] : std::numeric_limits<double>::quiet_NaN());
  return out;
}

/// The axis from the first to the last value (and mark), with labels inside the decades where there are few of them.
std::string x_axis(const LinePlot& plot) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  const auto include = [&](double x) {
    if (std::isfinite(x) && (x > 0.0 || !plot.log_x)) low = std::min(low, x), high = std::max(high, x);
  };
  for (const double x : plot.x) include(x);
  for (const auto& mark : plot.marks) include(mark.x);
  if (!(high > low)) return plot.log_x ? "set logscale x\n" : "";
  std::string script = fmt::format("set xrange [{:.9g}:{:.9g}]\n", low, high);
  if (!plot.log_x) return script;

  if (high < 4.0 * low) return script;  // too short for a logarithmic axis to have labels
  script += "set logscale x\nset mxtics 10\n";
  if (high > 600.0 * low) return script;
  const std::vector<double> digits = high > 60.0 * low ? std::vector{1.0, 3.0} : std::vector{1.0, 2.0, 5.0};
  std::vector<std::string> tics;
  for (int decade = static_cast<int>(std::floor(std::log10(low))); std::pow(10.0, decade) <= high; ++decade)
    for (const double digit : digits)
      if (const double tic = digit * std::pow(10.0, decade); tic >= low && tic <= high)
        tics.push_back(fmt::format("{:.9g}", tic));
  return script + fmt::format("set xtics ({})\n", fmt::join(tics, ", "));
}

void add_marks(std::string& script, const LinePlot& plot) {
  if (plot.x.empty()) return;
  const auto [low, high] = std::minmax_element(plot.x.begin(), plot.x.end());
  const double nearest = 0.05 * (*high - *low);  // texts closer than this would run into each other
  double last_text = -std::numeric_limits<double>::infinity();
  for (const auto& mark : plot.marks) {
    if (!std::isfinite(mark.x)) continue;
    script += fmt::format(
        "set arrow from first {0:.9g}, graph 0 to first {0:.9g}, graph 1 nohead back dt 3 lw 1 lc rgb '#94a3b8'\n",
        mark.x);
    if (mark.x - last_text < nearest) continue;
    script += fmt::format("set label {} at first {:.9g}, graph 1 center offset 0,0.7 noenhanced tc rgb '#64748b'\n",
                          text_literal(mark.text), mark.x);
    last_text = mark.x;
  }
}

}  // namespace

std::string text_literal(std::string_view text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') out += '\'';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + "'";
}

std::string shortened(std::string_view text, std::size_t most) {
  const auto begins_character = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; };
  std::size_t seen = 0;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (begins_character(text[i]) && seen++ == most) return std::string(text.substr(0, i)) + "…";
  return std::string(text);
}

std::string_view kind_colour(std::string_view task_kind) {
  if (task_kind == "dem") return "#0072B2";
  if (task_kind == "pbm") return "#D55E00";
  if (task_kind == "estimation") return "#009E73";
  if (task_kind == "monitor") return "#64748b";
  return "#CC79A7";
}

std::string_view category_colour(std::size_t i) { return kCategories[i % kCategories.size()]; }

std::string sequence_colour(std::size_t i, std::size_t n) {
  const double at = n < 2 ? 1.2 : 3.9 * static_cast<double>(i) / static_cast<double>(n - 1);
  const auto left = static_cast<std::size_t>(at);
  const double t = at - static_cast<double>(left);
  std::array<int, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c)
    rgb[c] = static_cast<int>(std::lround((1 - t) * kViridis[left][c] + t * kViridis[left + 1][c]));
  return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

Scale scale_for(const std::vector<const std::vector<double>*>& values) {
  double most = 0.0;
  for (const auto* list : values) most = std::max(most, largest(*list));
  if (most == 0.0 || (most >= 0.1 && most < 1e4)) return {};
  const int exponent = 3 * static_cast<int>(std::floor(std::log10(most) / 3.0));
  return {std::pow(10.0, exponent), "10" + superscript(exponent) + " "};
}

LengthUnit length_unit_for(double largest_metres) {
  if (largest_metres >= 1e-3) return {1e-3, "mm"};
  return {};
}

std::string data_block(std::string_view name, const std::vector<std::vector<double>>& columns,
                       const std::vector<std::size_t>& breaks) {
  std::string out = fmt::format("${} << EOD\n", name);
  const std::size_t n = columns.empty() ? 0 : columns.front().size();
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0 && std::binary_search(breaks.begin(), breaks.end(), i)) out += '\n';
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const double value = i < columns[c].size() ? columns[c][i] : std::numeric_limits<double>::quiet_NaN();
      if (c > 0) out += ' ';
      out += std::isfinite(value) ? fmt::format("{:.7g}", value) : "NaN";
    }
    out += '\n';
  }
  return out + "EOD\n";
}

bool has_numbers(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

std::vector<double> column_of(const std::vector<std::vector<double>>& rows, std::size_t j) {
  std::vector<double> column;
  for (const auto& row : rows) column.push_back(j < row.size() ? row[j] : std::numeric_limits<double>::quiet_NaN());
  return column;
}

std::vector<double> divided(std::vector<double> values, double by) {
  for (auto& value : values) value /= by;
  return values;
}

void trim_to_curves(LinePlot& plot) {
  std::size_t first = plot.x.size(), last = 0;
  for (const auto& line : plot.lines)
    for (std::size_t i = 0; i < line.y.size(); ++i)
      if (line.y[i] > 2e-3 * largest(line.y)) first = std::min(first, i), last = std::max(last, i);
  if (first > last) return;
  const auto begin = static_cast<std::ptrdiff_t>(first == 0 ? 0 : first - 1);
  const auto end = static_cast<std::ptrdiff_t>(std::min(last + 2, plot.x.size()));
  const auto cut = [&](std::vector<double>& values) {
    if (!values.empty()) values = {values.begin() + begin, values.begin() + end};
  };
  cut(plot.x);
  for (auto& line : plot.lines) cut(line.y);
}

std::string line_plot_script(const LinePlot& plot) {
  const auto rows = rows_to_draw(plot.x.size(), plot.lines.size(), plot.breaks);
  std::vector<std::size_t> breaks;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (std::binary_search(plot.breaks.begin(), plot.breaks.end(), rows[i])) breaks.push_back(i);
  std::vector<std::vector<double>> columns{chosen(plot.x, rows)};
  std::vector<std::string> draws;
  for (const auto& band : plot.bands) {
    if (!has_numbers(band.low) || !has_numbers(band.high)) continue;
    columns.push_back(chosen(band.low, rows));
    columns.push_back(chosen(band.high, rows));
    draws.push_back(fmt::format(
        "$data using 1:{}:{} with filledcurves fs transparent solid 0.15 noborder lc rgb '{}' title {} noenhanced",
        columns.size() - 1, columns.size(), band.colour, text_literal(band.title)));
  }
  bool any_line = false;
  for (const auto& line : plot.lines) {
    if (!has_numbers(line.y)) continue;
    any_line = true;
    columns.push_back(chosen(line.y, rows));
    draws.push_back(fmt::format("$data using 1:{} with {} dt {} lw 2 lc rgb '{}' {}", columns.size(),
                                plot.with_points ? "linespoints pt 7 ps 0.5" : "lines", line.dashed ? 2 : 1,
                                line.colour,
                                line.title.empty() ? "notitle" : "title " + text_literal(line.title) + " noenhanced"));
  }
  if (!any_line || !has_numbers(plot.x)) return "";

  std::string script = data_block("data", columns, breaks);
  script += fmt::format("set xlabel {}\nset ylabel {}\n", text_literal(plot.x_title), text_literal(plot.y_title));
  script += x_axis(plot);
  if (plot.from_zero) script += "set yrange [0:*]\n";
  add_marks(script, plot);
  return script + fmt::format("plot {}\n", fmt::join(draws, ", \\\n     "));
}

}  // namespace granary::report
