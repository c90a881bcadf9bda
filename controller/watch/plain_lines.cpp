#include "controller/watch/plain_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "controller/watch/row.hpp"
#include "controller/watch/words.hpp"

namespace granary::watch {

namespace {

constexpr std::size_t kAtFirst = 12;  ///< happenings told of what was before the first look
constexpr std::size_t kMinor = 5;     ///< ends of tasks told one by one in one look; more are counted

std::string at(double time, const std::string& words) { return fmt::format("{:>8.1f} s  {}", time, words); }

}  // namespace

std::string standing(const View& view) {
  std::string text = view.headline;
  if (view.burst) {
    text += fmt::format("; {:.4g} s of {:.4g} to {:.4g} s", view.burst_time, view.burst->start,
                        view.burst->start + view.burst->longest);
    if (!view.burst->dem && !view.sizes.empty() && !view.sizes.back().d50.empty())
      text += fmt::format(", d50 {:.1f} um at the outlet", 1e6 * view.sizes.back().d50.back());
    if (view.burst->dem && !view.contacts.empty())
      text += fmt::format(", {:.0f} particles", view.contacts.back().particles);
  }
  if (view.phase != Phase::waiting)
    text += fmt::format("; {} of {} cores busy{}", view.busy_cores, view.cores,
                        std::isfinite(view.core_use) ? ", use " + percent(view.core_use) : "");
  if (view.fit)
    text += fmt::format("; {} evaluations, {:.3g} squares per datum", view.fit->evaluations, view.fit->misfit);
  if (view.time_left) text += "; " + left_words(view.time_left->least, view.time_left->most);
  return text;
}

std::vector<std::string> PlainLines::lines(const View& view, double now) {
  std::vector<std::string> lines;
  if (!begun_) lines.push_back(fmt::format("{}: {} {}", view.folder, view.campaign, name(view.phase)));
  const bool first = !std::exchange(begun_, true);
  if (first && view.happenings.size() > kAtFirst) {
    const std::size_t before = view.n_happenings - kAtFirst;
    lines.push_back(fmt::format("          ({} before that)", plural(static_cast<long>(before), "event", "events")));
    told_ = before;
  }
  tell_happenings(view, lines);
  for (const std::string& warning : view.warnings)
    if (std::find(warnings_.begin(), warnings_.end(), warning) == warnings_.end())
      lines.push_back(at(view.time, "warning: " + warning));
  warnings_ = view.warnings;
  const bool ended = view.phase == Phase::ended;
  const bool waits_for_something_new = view.phase == Phase::waiting && view.headline != headline_;
  if (ended) {
    const std::string use = std::isfinite(view.core_use) ? ", core use " + percent(view.core_use) : "";
    lines.push_back(at(view.time, fmt::format("{} ({}{}; exit code {})", view.headline, duration(view.time), use,
                                              view.exit ? static_cast<int>(*view.exit) : 0)));
  } else if (waits_for_something_new || (view.phase != Phase::waiting && now - spoke_ >= every_)) {
    lines.push_back(at(view.time, standing(view)));
  }
  headline_ = view.headline;
  if (!lines.empty()) spoke_ = now;
  for (std::string& line : lines) line = clipped(line, 1000);
  return lines;
}

void PlainLines::tell_happenings(const View& view, std::vector<std::string>& lines) {
  if (view.n_happenings < told_) told_ = 0;  // the journal was written anew
  const std::uint64_t dropped = view.n_happenings - view.happenings.size();
  std::size_t k = static_cast<std::size_t>(std::max(told_, dropped) - dropped);
  const auto is_minor = [](const Happening& one) { return one.level == Level::minor; };
  const auto minor = static_cast<std::size_t>(
      std::count_if(view.happenings.begin() + static_cast<std::ptrdiff_t>(k), view.happenings.end(), is_minor));
  for (; k < view.happenings.size(); ++k) {
    const Happening& one = view.happenings[k];
    if (minor > kMinor && is_minor(one)) continue;
    lines.push_back(at(one.time, (one.level == Level::warning ? "warning: " : "") + one.words));
  }
  if (minor > kMinor) lines.push_back(at(view.time, standing(view)));
  told_ = view.n_happenings;
}

}  // namespace granary::watch
