#include "controller/run/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace granary::run {
using coupling::Kind;

namespace {
constexpr double kTerminalPeriod = 0.5;  // [s]
constexpr double kPlainPeriod = 5.0;     // [s]

std::string name_of(const coupling::BurstId& burst) {
  return fmt::format("round {} {}", burst.round, burst.kind == Kind::dem ? "DEM" : "PBM");
}

std::string bar(double share) {
  constexpr int kWidth = 20;
  const int full = std::clamp(static_cast<int>(share * kWidth + 0.5), 0, kWidth);
  return "[" + std::string(static_cast<std::size_t>(full), '#') +
         std::string(static_cast<std::size_t>(kWidth - full), '.') + "]";
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }
}  // namespace

Progress::Progress(pilot::EventLoop& loop, std::filesystem::path dir, bool quiet)
    : loop_(loop), dir_(std::move(dir)), quiet_(quiet), terminal_(::isatty(STDERR_FILENO) == 1) {}

Watcher Progress::watcher() {
  return {[this](const coupling::Event& each) { event(each); }, [this](const coupling::Action& each) { action(each); },
          [this](const std::string& line) { say(line); }};
}

void Progress::finish() {
  loop_.cancel(timer_);
  if (line_open_) std::fputs("\n", stderr);
  line_open_ = false;
}

void Progress::say(const std::string& line) {
  if (quiet_) return;
  if (line_open_) std::fputs("\r\033[K", stderr);
  line_open_ = false;
  fmt::print(stderr, "{:>8.1f} s  {}\n", loop_.now(), line);
}

void Progress::event(const coupling::Event& event) {
  if (std::holds_alternative<coupling::TaskEnded>(event)) {
    running_.reset();
    loop_.cancel(timer_);
  }
  if (const auto* stop = std::get_if<coupling::StopAsked>(&event)) say("stopping: " + stop->message);
  if (dir_.empty()) return;  // what a dry run exchanges is made up
  if (const auto* spoke = std::get_if<coupling::MonitorSpoke>(&event);
      spoke && spoke->verdict.outcome != monitor::Outcome::ended)
    say(fmt::format("{}: {}: {}", name_of(spoke->burst), monitor::name(spoke->verdict.outcome),
                    spoke->verdict.message));
  if (const auto* dem = std::get_if<coupling::DemExchanged>(&event))
    say(fmt::format("{} gives {:.3g} collisions and {:.3g} impacts per particle and second ({:.0f} and {:.0f} counted)",
                    name_of(dem->burst), dem->summary.collision_frequency, dem->summary.impact_frequency,
                    dem->summary.collisions, dem->summary.impacts));
  if (const auto* pbm = std::get_if<coupling::PbmExchanged>(&event); pbm && !pbm->summary.d50.empty())
    say(fmt::format("{} gives d50 {:.1f} to {:.1f} um, {:.3e} particles at {:.2f} s", name_of(pbm->burst),
                    1e6 * *std::min_element(pbm->summary.d50.begin(), pbm->summary.d50.end()),
                    1e6 * *std::max_element(pbm->summary.d50.begin(), pbm->summary.d50.end()), sum(pbm->summary.number),
                    pbm->summary.time));
}

void Progress::action(const coupling::Action& action) {
  if (const auto* start = std::get_if<coupling::StartBurst>(&action)) {
    say(fmt::format("{} starts at {:.4g} s: {}", name_of(start->burst), start->start_time, start->why.message));
    if (dir_.empty() || quiet_) return;
    running_ = *start;
    last_ = {};
    const char* file = start->burst.kind == Kind::dem ? "tallies.jsonl" : "progress.jsonl";
    reader_ = std::make_unique<json::LineReader>(dir_ / "bursts" / start->burst.folder() / file);
    loop_.cancel(timer_);
    timer_ = loop_.after(kTerminalPeriod, [this] { tick(); });
  }
  if (const auto* end = std::get_if<coupling::End>(&action)) {
    running_.reset();
    loop_.cancel(timer_);
    say(fmt::format("ends {}: {}", coupling::name(end->how), end->why.message));
  }
}

std::string Progress::burst_progress() {
  const auto lines = reader_->next();
  if (lines && !lines->empty()) last_ = lines->back();
  const double now = last_.number_or("time_s", running_->start_time);
  const double share = running_->longest > 0.0 ? (now - running_->start_time) / running_->longest : 0.0;
  std::string text = fmt::format("{} {} {:.3f} s of {:.4g} to {:.4g} s", name_of(running_->burst), bar(share), now,
                                 running_->start_time, running_->start_time + running_->longest);
  if (running_->burst.kind == Kind::pbm) {
    const auto d50 = last_.numbers("d50_m");
    if (!d50.empty()) text += fmt::format(", d50 at the outlet end {:.1f} um", 1e6 * d50.back());
  } else if (last_["particles"].is_array()) {
    double particles = 0.0;
    for (const json::Value& row : last_["particles"].items()) particles += sum(row.numbers());
    text += fmt::format(", {:.0f} particles", particles);
  }
  return text;
}

void Progress::tick() {
  if (!running_) return;
  timer_ = loop_.after(kTerminalPeriod, [this] { tick(); });
  if (terminal_) {
    fmt::print(stderr, "\r\033[K{:>8.1f} s  {}", loop_.now(), burst_progress());
    std::fflush(stderr);
    line_open_ = true;
  } else if (loop_.now() - last_plain_ >= kPlainPeriod) {
    last_plain_ = loop_.now();
    say(burst_progress());
  }
}

}  // namespace granary::run
