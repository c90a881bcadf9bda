#include "controller/watch/screen.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "controller/campaign/estimation.hpp"
#include "controller/watch/text_chart.hpp"
#include "controller/watch/words.hpp"

namespace granary::watch {

namespace {

constexpr int kLabel = 10;  ///< columns of the names on the left

Ink ink_of(Phase phase, const std::optional<Exit>& exit) {
  if (phase == Phase::waiting) return Ink::soft;
  if (!exit) return Ink::good;
  return *exit == Exit::ok ? Ink::good : *exit == Exit::stopped ? Ink::pbm : Ink::bad;
}

/// Two ends of a row, the right one at the right edge.
Row spread(Row left, const Row& right, int columns) {
  const int gap = columns - width_of(left) - width_of(right);
  left.push_back({std::string(static_cast<std::size_t>(std::max(2, gap)), ' ')});
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

Span label(const char* text) { return {fmt::format("{:<{}}", text, kLabel), Ink::soft}; }

std::string joined(const std::vector<std::string>& parts, bool unicode) {
  return fmt::format("{}", fmt::join(parts, unicode ? " · " : ", "));
}

/// Draws one view; the parts of the screen, from top to bottom.
class Screen {
 public:
  Screen(const View& view, ScreenSize size, bool unicode) : view_(view), size_(size), unicode_(unicode) {}

  std::vector<Row> rows() {
    header();
    if (view_.coupled) {
      burst();
      process();
      steadiness();
    }
    fit();
    const std::vector<Row> above = std::exchange(rows_, {});
    cores();
    running_tasks();
    const std::vector<Row> below = std::exchange(rows_, above);
    // A few events are always shown; the chart takes what is left, up to a height beyond which it tells no more.
    const int left = size_.rows - static_cast<int>(above.size() + below.size());
    if (view_.coupled) charts(std::clamp(left - 10, 0, 8));
    rows_.insert(rows_.end(), below.begin(), below.end());
    events();
    rows_.resize(std::min(rows_.size(), static_cast<std::size_t>(std::max(1, size_.rows))));
    return std::move(rows_);
  }

 private:
  void add(Row row) { rows_.push_back(std::move(row)); }

  void header() {
    Row left = {{view_.campaign, Ink::bold}, {"  "}, {std::string(name(view_.phase)), ink_of(view_.phase, view_.exit)}};
    if (view_.exit) left.push_back({fmt::format(" (exit code {})", static_cast<int>(*view_.exit)), Ink::soft});
    Row right = {{duration(view_.time)}};
    if (view_.time_left) right.push_back({", " + left_words(view_.time_left->least, view_.time_left->most), Ink::bold});
    add(spread(std::move(left), right, size_.columns));
    add({{view_.headline}});
    if (view_.time_left) add({{"left: " + view_.time_left->how, Ink::soft}});
    for (const std::string& warning : view_.warnings) add({{"! " + warning, Ink::bad}});
    std::string rule;
    for (int k = 0; k < size_.columns; ++k) rule += unicode_ ? "─" : "-";
    add({{rule, Ink::soft}});
  }

  void burst() {
    if (!view_.burst) return;
    const Burst& burst = *view_.burst;
    const double share = burst.longest > 0.0 ? (view_.burst_time - burst.start) / burst.longest : 0.0;
    add({{fmt::format("{:<{}}", fmt::format("{} {}", burst.dem ? "DEM" : "PBM", burst.round), kLabel),
          burst.dem ? Ink::dem : Ink::pbm},
         {bar(share, bar_columns(), unicode_), burst.dem ? Ink::dem : Ink::pbm},
         {fmt::format(" {:.4g} s of {:.4g} to {:.4g} s of {} time", view_.burst_time, burst.start,
                      burst.start + burst.longest, burst.dem ? "DEM" : "process")}});
  }

  void process() {
    const double share = view_.process_time / view_.process_end;
    add({label("process"),
         {bar(share, bar_columns(), unicode_)},
         {fmt::format(" {:.4g} s of {:.4g} s, DEM clock {:.4g} s", view_.process_time, view_.process_end,
                      view_.dem_time)}});
    if (view_.bursts.empty()) return;
    const Burst& last = view_.bursts.back();
    add({label("last"), {burst_words(last.folder) + " ended: " + last.reason}, {"  " + last.message, Ink::soft}});
  }

  void steadiness() {
    if (!view_.steadiness) return;
    const Steadiness& steady = *view_.steadiness;
    const auto mark = [&](bool yes) {
      return Span{unicode_ ? (yes ? "✓ " : "○ ") : (yes ? "x " : "o "), yes ? Ink::good : Ink::soft};
    };
    Row row = {label("steady?"),
               mark(steady.dem_quiet),
               {fmt::format("quiet {:.3g}/{:.3g} s  ", steady.quiet_time, steady.window)},
               mark(steady.rounds >= steady.least_rounds),
               {fmt::format("rounds {}/{}  ", steady.rounds, steady.least_rounds)},
               mark(steady.rounds_agree)};
    const double allowed = 100.0 * steady.tolerance;
    if (std::isnan(steady.change))
      row.push_back({fmt::format("differ ?/{:.3g} %: two rounds are needed", allowed)});
    else
      row.push_back({fmt::format("differ {:.3g}/{:.3g} %: {}{}", 100.0 * std::abs(steady.change), allowed,
                                 steady.changed, steady.where == "all" ? "" : ", " + steady.where)});
    add(std::move(row));
  }

  void charts(int height) {
    std::vector<double> time, outlet;
    for (const SizePoint& point : view_.sizes) {
      if (point.d50.empty()) continue;
      time.push_back(point.time);
      outlet.push_back(1e6 * point.d50.back());
    }
    if (!time.empty() && height > 0) {
      const auto& d50 = view_.sizes.back().d50;
      const auto [least, most] = std::minmax_element(d50.begin(), d50.end());
      add({});
      add({label("d50"),
           {fmt::format("{:.1f} um at the outlet", outlet.back()), Ink::pbm},
           {fmt::format(", {:.1f} to {:.1f} um over the compartments", 1e6 * *least, 1e6 * *most), Ink::soft}});
      const auto [low, high] = std::minmax_element(outlet.begin(), outlet.end());
      const auto lines = area(resampled(time, outlet, chart_columns()), *low, *high, height, unicode_);
      for (int r = 0; r < height; ++r) {
        const std::string at = r == 0            ? fmt::format("{:.1f}", *high)
                               : r == height - 1 ? fmt::format("{:.1f}", *low)
                                                 : "";
        add({{fmt::format("{:>{}} ", at, kLabel - 1), Ink::soft}, {lines[static_cast<std::size_t>(r)], Ink::pbm}});
      }
      const std::string from = fmt::format("{:.3g} s", time.front()), to = fmt::format("{:.4g} s", time.back());
      add({{fmt::format("{:{}}{:<{}}{}", "", kLabel, from, std::max(0, chart_columns() - width_of(to)), to),
            Ink::soft}});
    }
    sparkline_of_contacts();
  }

  void sparkline_of_contacts() {
    if (view_.contacts.empty()) return;
    std::vector<double> time, rate;
    for (const ContactPoint& point : view_.contacts) {
      time.push_back(point.time);
      rate.push_back(point.collisions);
    }
    const auto lines =
        area(resampled(time, rate, spark_columns()), 0.0, *std::max_element(rate.begin(), rate.end()), 1, unicode_);
    const ContactPoint& now = view_.contacts.back();
    add({label("contacts"),
         {lines[0], Ink::dem},
         {fmt::format(" {:.3g} collisions, {:.3g} impacts/s each; {:.0f} particles", now.collisions, now.impacts,
                      now.particles)}});
  }

  /// "fit  0.6 chi2/datum, 131 evaluations, search ▇▅▂▁", then the parameters.
  void fit() {
    if (!view_.fit) return;
    const Fit& fit = *view_.fit;
    std::vector<double> time, log_cost;
    for (const Fit::Point& point : fit.points) {
      time.push_back(point.time);
      log_cost.push_back(std::log10(std::max(point.cost, 1e-3)));
    }
    const auto [least, most] = std::minmax_element(log_cost.begin(), log_cost.end());
    const double low = *least - 0.05, high = std::max(*most, *least + 0.1);
    const auto line = area(resampled(time, log_cost, spark_columns()), low, high, 1, unicode_);
    add({label("fit"),
         {line[0], Ink::estimation},
         {fmt::format(" {:.3g} squares per datum after {}, {}", fit.misfit,
                      plural(static_cast<long>(fit.evaluations), "evaluation", "evaluations"), fit.phase)}});
    for (const Fit::Parameter& one : fit.parameters) {
      const std::string interval =
          std::isfinite(one.low)
              ? fmt::format(" ({} to {})", campaign::shown(one.low, one.unit), campaign::shown(one.high, one.unit))
              : "";
      add({{fmt::format("{:{}}{} {}", "", kLabel, one.name, campaign::shown(one.value, one.unit))},
           {interval, Ink::soft}});
    }
  }

  void cores() {
    Row row = {label("cores")};
    if (view_.phase != Phase::ended && view_.phase != Phase::waiting) {
      row.push_back({fmt::format("{} of {} busy ", view_.busy_cores, view_.cores)});
      for (const auto& [kind, cores] : view_.busy_by_kind)
        row.push_back({fmt::format(" {} {} ",
                                   kind == "dem"   ? "DEM"
                                   : kind == "pbm" ? "PBM"
                                                   : kind,
                                   cores),
                       ink_of_kind(kind)});
    } else if (view_.cores > 0) {
      row.push_back({plural(view_.cores, "core", "cores")});
    }
    if (view_.nodes > 1) row.push_back({fmt::format(" on {} nodes", view_.nodes)});
    if (std::isfinite(view_.core_use)) {
      row.push_back({fmt::format("  use {}", percent(view_.core_use))});
      if (view_.core_use_fillers > 0.0)
        row.push_back({fmt::format(", of which estimation {}", percent(view_.core_use_fillers)), Ink::estimation});
      row.push_back({"  "});
      row.push_back({use_over_time(std::min(spark_columns(), size_.columns - width_of(row))), Ink::soft});
    }
    add(std::move(row));
    std::vector<std::string> counts;
    for (const auto& [state, count] : view_.counts) counts.push_back(fmt::format("{} {}", count, state));
    if (counts.empty()) return;
    row = {label("tasks"), {joined(counts, unicode_)}};
    if (view_.fillers > 0)
      row.push_back({fmt::format("  estimation: {} of {} done", view_.fillers_done, view_.fillers), Ink::estimation});
    add(std::move(row));
  }

  std::string use_over_time(int columns) const {
    std::vector<double> time, total;
    for (const auto& [kind, busy] : view_.core_history.busy) {
      total.resize(std::max(total.size(), busy.size()), 0.0);
      for (std::size_t k = 0; k < busy.size(); ++k) total[k] += busy[k];
    }
    for (std::size_t k = 0; k < total.size(); ++k) time.push_back(view_.core_history.slice * static_cast<double>(k));
    if (columns < 4 || time.empty()) return "";
    return area(resampled(time, total, columns), 0.0, view_.cores, 1, unicode_)[0];
  }

  void running_tasks() {
    const std::size_t most = static_cast<std::size_t>(std::max(2, size_.rows / 4));
    for (std::size_t k = 0; k < std::min(most, view_.tasks.size()); ++k) {
      const RunningTask& task = view_.tasks[k];
      std::string where = task.cores.empty() ? "no core" : fmt::format("core {}", task.cores.front());
      if (task.cores.size() > 1) where = fmt::format("{} cores from {}", task.cores.size(), task.cores.front());
      add({{fmt::format("{:{}}", "", kLabel)},
           {fmt::format("{:<24}", task.name), ink_of_kind(task.kind)},
           {fmt::format(" {:<10} {:>12}  {}{}", task.state, duration(task.seconds), where,
                        task.attempt > 1 ? fmt::format(", attempt {}", task.attempt) : "")}});
    }
    if (view_.tasks.size() > most)
      add({{fmt::format("{:{}}and {} more", "", kLabel, view_.tasks.size() - most), Ink::soft}});
  }

  void events() {
    const int left = size_.rows - static_cast<int>(rows_.size()) - 1;
    if (left < 1 || view_.happenings.empty()) return;
    add({});
    const std::size_t n = std::min(view_.happenings.size(), static_cast<std::size_t>(left));
    for (std::size_t k = view_.happenings.size() - n; k < view_.happenings.size(); ++k) {
      const Happening& one = view_.happenings[k];
      const Ink ink = one.level == Level::warning ? Ink::bad : one.level == Level::minor ? Ink::soft : Ink::plain;
      add({{fmt::format("{:>{}} ", clock_of(one.time), kLabel - 1), Ink::soft}, {one.words, ink}});
    }
  }

  int bar_columns() const { return std::clamp(size_.columns / 4, 10, 32); }
  int chart_columns() const { return std::max(8, size_.columns - kLabel - 1); }
  int spark_columns() const { return std::clamp(size_.columns / 4, 8, 40); }

  const View& view_;
  ScreenSize size_;
  bool unicode_;
  std::vector<Row> rows_;
};

}  // namespace

std::vector<Row> screen(const View& view, ScreenSize size, bool unicode) { return Screen(view, size, unicode).rows(); }

}  // namespace granary::watch
