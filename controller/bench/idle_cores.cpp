#include "controller/bench/idle_cores.hpp"

#include <algorithm>
#include <map>
#include <string>

#include "common/math/percentile.hpp"
#include "pilot/journal/journal.hpp"
#include "pilot/task/core_set.hpp"

namespace granary::bench {
namespace {

using json::Value;

/// Follows the cores of one journal from record to record.
class Cores {
 public:
  explicit Cores(std::int64_t n) {
    for (int core = 0; core < n; ++core) idle_since_[core] = 0.0;
  }

  void take(const pilot::Record& record) {
    const Value& payload = record.payload;
    if (!payload["time_s"].is_number() || !payload["id"].is_integer()) return;
    const double time = payload["time_s"].as_number();
    const std::int64_t id = payload["id"].as_integer();
    if (record.kind == "task.submit") {
      const Value& fill = payload["task"]["fill"];
      fills_[id] = fill.is_bool() && fill.as_bool();
      if (fills_[id]) work_since_ = std::min(work_since_, time);
    }
    if (record.kind == "task.place" || record.kind == "task.resume")
      cores_[id] = pilot::CoreSet::parse(payload.text_or("cores", "")).value_or(pilot::CoreSet());
    if (record.kind == "task.start" || record.kind == "task.resume") begins(id, time);
    if (record.kind == "task.exit" || record.kind == "task.suspend") ends(id, time, record.kind == "task.suspend");
  }

  IdleCores at(double end) {
    for (const auto& [core, since] : idle_since_) seen_.afterwards += end - since;
    return seen_;
  }

 private:
  void begins(std::int64_t id, double time) {
    cores_[id].for_each([&](int core) {
      const auto idle = idle_since_.find(core);
      if (idle == idle_since_.end()) return;
      const double from = std::max(idle->second, std::min(work_since_, time));
      seen_.before_rates += from - idle->second;
      seen_.at_switches += time - from;
      if (fills_[id]) seen_.put_to_work.push_back(time - from);
      if (const auto told = told_to_go_.find(core); told != told_to_go_.end() && !fills_[id])
        seen_.given_back.push_back(time - told->second);
      idle_since_.erase(idle);
      told_to_go_.erase(core);
    });
  }

  void ends(std::int64_t id, double time, bool suspended) {
    cores_[id].for_each([&](int core) {
      idle_since_[core] = time;
      if (suspended) told_to_go_[core] = time;
    });
    cores_[id] = {};  // a suspended filler that ends has none
  }

  std::map<std::int64_t, bool> fills_;
  std::map<std::int64_t, pilot::CoreSet> cores_;
  std::map<int, double> idle_since_, told_to_go_;
  double work_since_ = 1e300;  ///< the first evaluations were submitted then
  IdleCores seen_;
};

Value spread_of(const std::vector<double>& seconds) {
  return Value::object({{"p50", 1e3 * percentile(seconds, 0.5)},
                        {"p99", 1e3 * percentile(seconds, 0.99)},
                        {"most", 1e3 * percentile(seconds, 1.0)},
                        {"times", static_cast<std::int64_t>(seconds.size())}});
}

}  // namespace

Result<IdleCores> idle_cores_of(const std::filesystem::path& journal) {
  GRANARY_TRY(const pilot::JournalContent content, pilot::read_journal(journal));
  if (content.records.empty() || content.records.front().kind != "pilot.open")
    return Error{journal.string() + ": it does not begin with a pilot's \"pilot.open\"."};
  Cores cores(content.records.front().payload["nodes"].items().front().integer_or("cores", 1));
  double end = 0.0;
  for (const pilot::Record& record : content.records) {
    end = record.payload.number_or("time_s", end);
    if (record.kind == "estimation.over") break;
    cores.take(record);
  }
  return cores.at(end);
}

Value to_json(const std::vector<IdleCores>& campaigns) {
  IdleCores all;
  for (const IdleCores& one : campaigns) {
    all.put_to_work.insert(all.put_to_work.end(), one.put_to_work.begin(), one.put_to_work.end());
    all.given_back.insert(all.given_back.end(), one.given_back.begin(), one.given_back.end());
    all.before_rates += one.before_rates;
    all.at_switches += one.at_switches;
    all.afterwards += one.afterwards;
  }
  return Value::object({{"put_to_work_ms", spread_of(all.put_to_work)},
                        {"given_back_ms", spread_of(all.given_back)},
                        {"idle_core_s", Value::object({{"before_rates", all.before_rates},
                                                       {"at_switches", all.at_switches},
                                                       {"afterwards", all.afterwards}})}});
}

}  // namespace granary::bench
