#include "controller/coupling/update.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "controller/monitor/tallies.hpp"

namespace granary::coupling {

namespace {

using monitor::kInstant;

using monitor::Outcome;

std::string settings_to_look_at(const monitor::Verdict& verdict) {
  const json::Value& settings = verdict.details["settings"];
  if (!settings.is_array() || settings.size() == 0) return "";
  std::string text = " Settings to look at:";
  for (const json::Value& setting : settings.items())
    if (setting.is_string()) text += " " + setting.as_string();
  return text + ".";
}

/// One update: a copy of the state to change, and the actions asked for on the way.
class Update {
 public:
  Update(State state, const Settings& settings) : s_(std::move(state)), settings_(settings) {}

  Step take() && { return {std::move(s_), std::move(actions_)}; }

  void operator()(const Began&) {
    if (s_.phase != Phase::waiting) return;
    s_.process_clock = settings_.process_start;
    const Kind first = settings_.mode == Mode::pbm_only ? Kind::pbm : Kind::dem;
    start({1, first}, {"begin", "the campaign begins", json::Value::object()});
  }

  void operator()(const Resumed&) {
    if (s_.ended == End::How::steady || s_.ended == End::How::limit) return;
    // Stopped, failed (a full disk, a lost node) or cut off: what was asked for last is asked for again.
    const bool handing_over = s_.phase == Phase::exchanging || (s_.phase == Phase::ended && is_over(s_.burst));
    s_.stop_asked = false;
    s_.stop_message.clear();
    s_.failure.clear();
    s_.ended.reset();
    s_.why_ended = {};
    const bool nothing_yet = s_.attempt == 0 && s_.bursts.empty();
    if (nothing_yet) {
      s_.phase = Phase::waiting;
      return (*this)(Began{});
    }
    const Why why{"resumed", "the campaign goes on from " + s_.burst.folder(), json::Value::object()};
    if (s_.phase == Phase::closing) return ask(AskMonitor{s_.burst, s_.attempt, why});
    if (handing_over) {
      s_.phase = Phase::exchanging;
      return ask(Exchange{s_.burst, s_.attempt, s_.bursts.back().end_time, why});
    }
    start_attempt(s_.attempt + 1, why);
  }

  void operator()(const StopAsked& event) {
    if (s_.phase == Phase::ended || s_.stop_asked) return;
    s_.stop_asked = true;
    s_.stop_message = event.message;
    const Why why{"stopped", event.message, json::Value::object()};
    if (s_.phase == Phase::waiting) return end(End::How::stopped, why);
    if (s_.phase == Phase::running) stop(why);
    // In the other phases the burst is over: its result is brought home first, and nothing further is started.
  }

  void operator()(const TaskStarted& event) { concerns(event); }

  void operator()(const MonitorSpoke& event) {
    if (!concerns(event) || s_.verdict) return;
    if (s_.phase == Phase::running) {
      s_.verdict = event.verdict;
      if (event.verdict.outcome == Outcome::diverged) return stop(diverging());
      if (decides())
        stop({std::string(monitor::name(event.verdict.outcome)), event.verdict.message,
              monitor::to_json(event.verdict)});
    } else if (s_.phase == Phase::stopping) {
      s_.verdict = event.verdict;  // heard while the user's stop is under way
    } else if (s_.phase == Phase::closing) {
      s_.verdict = event.verdict;
      conclude();
    }
  }

  void operator()(const MonitorFailed& event) {
    if (!concerns(event) || s_.verdict) return;
    const Why why{"monitor_failed", fmt::format("the monitor of {} failed: {}", s_.burst.folder(), event.message),
                  json::Value::object()};
    if (s_.phase == Phase::closing) return end(End::How::failed, why);
    if (s_.phase != Phase::running) return;
    s_.failure = why.message;
    stop(why);
  }

  void operator()(const TaskEnded& event) {
    if (!concerns(event) || (s_.phase != Phase::running && s_.phase != Phase::stopping)) return;
    s_.program_end = event.time;
    const auto numbers = json::Value::object({{"time_s", event.time ? json::Value(*event.time) : json::Value()}});
    const bool by_user = s_.stop_asked && !decides();
    if (!s_.failure.empty()) return end(End::How::failed, {"failed", s_.failure, numbers});
    if (event.outcome == TaskEnded::Outcome::diverged) return end(End::How::failed, diverging(event.message));
    if (by_user && event.outcome != TaskEnded::Outcome::finished)
      return end(End::How::stopped, {"stopped", s_.stop_message, numbers});
    if (event.outcome == TaskEnded::Outcome::failed)
      return end(End::How::failed, {"failed", fmt::format("{} failed: {}", s_.burst.folder(), event.message), numbers});
    if (event.outcome == TaskEnded::Outcome::stopped && s_.phase == Phase::running)
      return end(
          End::How::stopped,
          {"stopped", fmt::format("{} was stopped from outside. {}", s_.burst.folder(), event.message), numbers});
    if (monitored() && !s_.verdict) {
      s_.phase = Phase::closing;
      return ask(AskMonitor{
          s_.burst, s_.attempt, {"ended", s_.burst.folder() + " ended before its monitor had spoken", numbers}});
    }
    conclude();
  }

  void operator()(const DemExchanged& event) {
    if (!concerns(event) || s_.phase != Phase::exchanging || event.burst.kind != Kind::dem) return;
    s_.dem_clock = s_.bursts.back().end_time;
    s_.dem = event.summary;
    count_steady_time(event.summary);
    start({s_.burst.round, Kind::pbm},
          {s_.bursts.back().reason, "the rates of " + s_.burst.folder() + " are ready", steadiness()});
  }

  void operator()(const PbmExchanged& event) {
    if (!concerns(event) || s_.phase != Phase::exchanging || event.burst.kind != Kind::pbm) return;
    s_.process_clock = s_.bursts.back().end_time;
    s_.rounds.push_back({s_.dem.value_or(DemSummary{}), event.summary});
    s_.dem.reset();
    auto [how, why] = after_round();
    if (how) return end(*how, std::move(why));
    start({s_.burst.round + 1, Kind::dem}, std::move(why));
  }

  void operator()(const ExchangeFailed& event) {
    if (!concerns(event) || s_.phase != Phase::exchanging) return;
    end(End::How::failed,
        {"exchange_failed", fmt::format("{}: {}", s_.burst.folder(), event.message), json::Value::object()});
  }

 private:
  void ask(Action action) { actions_.push_back(std::move(action)); }

  /// Is this about the burst and attempt we are at? A later attempt than we know of is the pilot's retry: what was
  /// heard of the one before no longer counts.
  template <class E>
  bool concerns(const E& event) {
    if (s_.phase == Phase::waiting || s_.phase == Phase::ended) return false;
    if (event.burst != s_.burst || event.attempt < s_.attempt) return false;
    if (event.attempt == s_.attempt) return true;
    if (s_.phase != Phase::running && s_.phase != Phase::stopping) return false;
    s_.attempt = event.attempt;
    s_.verdict.reset();
    s_.failure.clear();
    s_.phase = Phase::running;
    if (s_.stop_asked) stop({"stopped", s_.stop_message, json::Value::object()});
    return true;
  }

  bool is_over(const BurstId& burst) const { return !s_.bursts.empty() && s_.bursts.back().burst == burst; }
  bool two_way() const { return settings_.mode == Mode::two_way; }
  bool monitored() const { return two_way() || s_.burst.kind == Kind::dem; }

  /// Does what the monitor said end this burst? One-way, the DEM is run until its numbers are good, whatever moves
  /// meanwhile.
  bool decides() const {
    if (!s_.verdict || !monitored()) return false;
    const Outcome outcome = s_.verdict->outcome;
    return outcome == Outcome::steady || outcome == Outcome::converged || (outcome == Outcome::drifted && two_way());
  }

  double longest() const {
    if (s_.burst.kind == Kind::dem) return settings_.longest_dem_burst;
    const double left = settings_.process_end() - s_.process_clock;
    return two_way() ? std::min(settings_.longest_pbm_burst, left) : left;
  }

  Why diverging(const std::string& said_by_program = "") {
    const std::string said =
        s_.verdict && s_.verdict->outcome == Outcome::diverged ? s_.verdict->message : said_by_program;
    const std::string hint = s_.verdict ? settings_to_look_at(*s_.verdict) : "";
    s_.failure = fmt::format("{} diverged: {}.{}", s_.burst.folder(), said, hint);
    return {"diverged", s_.failure, s_.verdict ? monitor::to_json(*s_.verdict) : json::Value::object()};
  }

  void start(BurstId burst, Why why) {
    s_.burst = burst;
    s_.attempt = 0;
    if (s_.stop_asked) return end(End::How::stopped, {"stopped", s_.stop_message, json::Value::object()});
    start_attempt(1, std::move(why));
  }

  /// The burst's start follows from the state alone, so a resumed one starts just as it did the first time.
  void start_attempt(int attempt, Why why) {
    const bool dem = s_.burst.kind == Kind::dem;
    s_.attempt = attempt;
    s_.phase = Phase::running;
    s_.verdict.reset();
    s_.program_end.reset();
    s_.burst_start = dem ? s_.dem_clock : s_.process_clock;
    StartBurst action;
    action.burst = s_.burst;
    action.attempt = attempt;
    action.start_time = s_.burst_start;
    action.longest = longest();
    if (s_.burst.round > 1) {
      action.restart = BurstId{s_.burst.round - 1, s_.burst.kind};
      action.restart_time = s_.burst_start;
    }
    if (!dem && settings_.mode != Mode::pbm_only) action.takes_from = BurstId{s_.burst.round, Kind::dem};
    if (dem && s_.burst.round > 1) action.takes_from = BurstId{s_.burst.round - 1, Kind::pbm};
    action.monitored = monitored();
    action.watch_drift = two_way();
    action.why = std::move(why);
    ask(std::move(action));
  }

  void stop(Why why) {
    s_.phase = Phase::stopping;
    ask(StopTask{s_.burst, s_.attempt, std::move(why)});
  }

  void end(End::How how, Why why) {
    s_.phase = Phase::ended;
    s_.ended = how;
    s_.why_ended = why;
    ask(End{how, std::move(why)});
  }

  /// The burst is over and its monitor has been heard: why it ended, and where the other side takes over.
  void conclude() {
    if (s_.verdict && s_.verdict->outcome == Outcome::diverged) return end(End::How::failed, diverging());
    const bool dem = s_.burst.kind == Kind::dem;
    const double last =
        s_.program_end.value_or(s_.verdict && decides() ? s_.verdict->time : s_.burst_start + longest());
    // A PBM may have run on while its monitor was reading: it goes back to where the drift was seen. A DEM can not.
    const double at = !dem && decides() ? s_.verdict->time : last;
    if (!(at > s_.burst_start)) {
      const auto numbers = json::Value::object({{"start_time_s", s_.burst_start}, {"end_time_s", at}});
      return end(End::How::failed,
                 {"no_progress",
                  fmt::format("{} ended at {:.6g} s, where it began: nothing was simulated. See its log.",
                              s_.burst.folder(), at),
                  numbers});
    }
    Why why{"longest", fmt::format("{} reached its longest duration at {:.6g} s", s_.burst.folder(), at),
            json::Value::object()};
    if (!dem && at >= settings_.process_end() - kInstant)
      why = {"end", fmt::format("the process reached its end at {:.6g} s", at), json::Value::object()};
    if (decides())
      why = {std::string(monitor::name(s_.verdict->outcome)), s_.verdict->message, monitor::to_json(*s_.verdict)};
    s_.bursts.push_back({s_.burst, s_.attempt, why.reason, s_.burst_start, at, why.message});
    s_.phase = Phase::exchanging;
    ask(Exchange{s_.burst, s_.attempt, at, std::move(why)});
  }

  /// DEM time in a row, over bursts, in which nothing moved: within a burst its monitor saw no drift, and between any
  /// two of the bursts nothing differs by more than the threshold.
  void count_steady_time(const DemSummary& latest) {
    const bool drifted = s_.bursts.back().reason == "drifted";
    const bool moved = std::any_of(s_.steady_run.begin(), s_.steady_run.end(), [&](const DemSummary& earlier) {
      return compare(earlier, latest).beyond(settings_.threshold, settings_.significance) != nullptr;
    });
    if (drifted || moved) s_.steady_run.clear();
    if (!drifted) s_.steady_run.push_back(latest);
    s_.steady_time = 0.0;
    for (const DemSummary& burst : s_.steady_run) s_.steady_time += burst.end_time - burst.start_time;
  }

  json::Value steadiness() const {
    return json::Value::object({{"steady_time_s", s_.steady_time},
                                {"steady_window_s", settings_.steady_window},
                                {"dem_clock_s", s_.dem_clock},
                                {"process_clock_s", s_.process_clock}});
  }

  /// How the campaign ends with the round that is over; nothing: it goes on, and Why names the reason the PBM burst
  /// ended.
  std::pair<std::optional<End::How>, Why> after_round() const {
    json::Value numbers = steadiness();
    const int round = s_.burst.round;
    const BurstRecord& last = s_.bursts.back();
    numbers.set("round", round).set("pbm_ended", last.reason).set("steady_tolerance", settings_.steady_tolerance);

    bool settled = false;
    if (s_.rounds.size() >= 2) {
      const Change change = compare(s_.rounds[s_.rounds.size() - 2], s_.rounds.back());
      const Difference* largest = change.largest();
      const Difference* too_large = change.beyond(settings_.steady_tolerance, settings_.significance);
      settled = largest != nullptr && too_large == nullptr;
      if (largest != nullptr) numbers.set("largest_change", to_json(*largest));
      if (too_large != nullptr) numbers.set("too_large_change", to_json(*too_large));
    }
    const bool long_enough = s_.steady_time >= settings_.steady_window - kInstant;
    const bool gone_through = s_.process_clock >= settings_.earliest_steady - kInstant;
    numbers.set("dem_steady", long_enough).set("rounds_agree", settled);
    numbers.set("earliest_steady_s", settings_.earliest_steady);

    const auto ends = [&](End::How how, std::string message) {
      return std::pair{std::optional(how), Why{std::string(name(how)), std::move(message), std::move(numbers)}};
    };
    if (two_way() && settled && long_enough && gone_through && last.reason != "drifted" &&
        round >= settings_.least_rounds)
      return ends(
          End::How::steady,
          fmt::format("nothing in the DEM moved by more than {:.3g} % over {:.6g} s, and rounds {} and {} agree "
                      "within {:.3g} %",
                      100.0 * settings_.threshold, s_.steady_time, round - 1, round,
                      100.0 * settings_.steady_tolerance));
    if (s_.process_clock >= settings_.process_end() - kInstant)
      return ends(End::How::limit, fmt::format("the process reached its end at {:.6g} s", s_.process_clock));
    if (!two_way()) return ends(End::How::limit, fmt::format("the process ended at {:.6g} s", s_.process_clock));
    if (round >= settings_.most_rounds)
      return ends(End::How::limit, fmt::format("{} rounds were allowed, and not steady yet", settings_.most_rounds));
    return {std::nullopt,
            {last.reason,
             fmt::format("round {} is over and not steady yet: the DEM goes on with the sizes of {}", round,
                         s_.burst.folder()),
             std::move(numbers)}};
  }

  State s_;
  std::vector<Action> actions_;
  const Settings& settings_;
};

}  // namespace

Step update(const State& now, const Event& event, const Settings& settings) {
  Update change(now, settings);
  std::visit(change, event);
  return std::move(change).take();
}

}  // namespace granary::coupling
