// A run directory as a campaign leaves it, written line by line by the test: journal, campaign.json, files of the
// bursts.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "pilot/journal/line.hpp"

namespace granary::test {

class RecordedCampaign {
 public:
  explicit RecordedCampaign(std::filesystem::path dir) : dir_(std::move(dir)) {
    std::filesystem::create_directories(dir_);
  }

  /// campaign.json of a two-way coupled campaign: process 0 to 60 s, DEM quiet for 0.4 s, 3 rounds at least.
  void coupled() const {
    write("campaign.json",
          R"({"understood": {"kind": "coupled", "name": "mixer", "duration_s": 60.0,
              "coupling": {"mode": "two-way", "steady_window_s": 0.4, "steady_tolerance": 0.05, "least_rounds": 3, "most_rounds": 50},
              "dem": {"longest_burst_s": 0.2}, "dem_case": {"settle_time": 0.05}, "pbm_case": {"start_time": 0.0}}})");
  }
  void tasks() const { write("campaign.json", R"({"understood": {"kind": "tasks", "name": "list"}})"); }

  /// Appends a record written at `time` on the pilot's clock, of a pilot that began at 1000 s of wall time.
  void record(const std::string& kind, double time, const std::string& payload) {
    std::string text;
    pilot::append_line(text, {++sequence_, 1000.0 + time, kind, payload});
    append("journal.jsonl", text);
  }
  void open(double time = 0.0, int cores = 2) {
    record("pilot.open", time, fmt::format(R"({{"time_s":{},"nodes":[{{"name":"here","cores":{}}}]}})", time, cores));
  }
  void close(double time) { record("pilot.close", time, fmt::format(R"({{"time_s":{}}})", time)); }
  void submit(int id, const std::string& task) {
    record("task.submit", 0.0, fmt::format(R"({{"time_s":0.0,"id":{},"task":{}}})", id, task));
  }
  /// `cores` as text: "0-3,8".
  void place(double time, int id, const std::string& cores) {
    record("task.place", time, fmt::format(R"({{"time_s":{},"id":{},"attempt":1,"cores":"{}"}})", time, id, cores));
  }
  void exit(double time, int id, int code) {
    record("task.exit", time,
           fmt::format(R"({{"time_s":{},"id":{},"attempt":1,"exit_code":{},"signal":0}})", time, id, code));
  }
  void start_burst(double time, const std::string& burst, double start, double longest,
                   const std::string& numbers = "{}") {
    record("coupling.decision", time,
           fmt::format(R"({{"action":"start_burst","burst":"{}","attempt":1,"start_time_s":{},"longest_s":{},)"
                       R"("why":{{"reason":"begin","message":"so it goes on","numbers":{}}}}})",
                       burst, start, longest, numbers));
  }
  void exchange(double time, const std::string& burst, double at, const std::string& reason,
                const std::string& message) {
    record(
        "coupling.decision", time,
        fmt::format(
            R"({{"action":"exchange","burst":"{}","attempt":1,"time_s":{},"why":{{"reason":"{}","message":"{}","numbers":{{}}}}}})",
            burst, at, reason, message));
  }
  void event(double time, const std::string& event, int round, const std::string& kind, const std::string& more) {
    record("coupling.event", time,
           fmt::format(R"({{"event":"{}","round":{},"kind":"{}","attempt":1,{}}})", event, round, kind, more));
  }
  void end(double time, const std::string& how, const std::string& message) {
    record("coupling.decision", time,
           fmt::format(R"({{"action":"end","how":"{}","why":{{"reason":"{}","message":"{}","numbers":{{}}}}}})", how,
                       how, message));
  }

  /// A DEM burst and the PBM burst that takes its rates, 4 s of pilot time and 2 s of process time together.
  void round(int n) {
    const double at = 4.0 * (n - 1), process = 2.0 * (n - 1);
    const std::string dem = fmt::format("{:04}-dem", n), pbm = fmt::format("{:04}-pbm", n);
    start_burst(at, dem, 0.25 * (n - 1), 0.2);
    tallies(dem, {0.25 * (n - 1) + 0.1, 0.25 * n});
    event(at + 3.0, "task_ended", n, "dem", R"("outcome":"finished")");
    exchange(at + 3.0, dem, 0.25 * n, "longest", dem + " reached its longest duration");
    event(at + 3.0, "dem_exchanged", n, "dem",
          R"("summary":{"particles":900.0,"collision_frequency_1_s":100.0,"impact_frequency_1_s":3.0})");
    start_burst(at + 3.0, pbm, process, 10.0, fmt::format(R"({{"steady_time_s":{},"steady_window_s":0.4}})", 0.2 * n));
    progress(pbm, {process, process + 1.0, process + 2.0, process + 3.0});  // it ran on beyond the drift
    event(at + 4.0, "task_ended", n, "pbm", R"("outcome":"stopped")");
    exchange(at + 4.0, pbm, process + 2.0, "drifted", "d50_m in compartment 2 moved by +16 %");
    event(at + 4.0, "pbm_exchanged", n, "pbm", R"("summary":{"d50_m":[7e-5,9e-5],"number":[1e9,2e9]})");
  }

  void progress(const std::string& burst, const std::vector<double>& times) const {
    std::string text = R"({"format":"granary-progress-1"})"
                       "\n";
    for (const double t : times)
      text += fmt::format(R"({{"time_s":{},"number":[1e9,2e9],"d50_m":[{},{}]}})"
                          "\n",
                          t, 6e-5, 6e-5 + 2e-6 * t);
    append("bursts/" + burst + "/progress.jsonl", text);
  }
  /// 900 particles, 450 collisions and 90 impacts a window of 0.01 s.
  void tallies(const std::string& burst, const std::vector<double>& times) const {
    std::string text = R"({"format":"granary-tallies-1"})"
                       "\n";
    for (const double t : times)
      text += fmt::format(R"({{"time_s":{},"window_s":0.01,"particles":[[400,500]],"collisions":[[200,150],[150,100]],)"
                          R"("impacts":{{"impeller":[60,30]}}}})"
                          "\n",
                          t);
    append("bursts/" + burst + "/tallies.jsonl", text);
  }

  void write(const std::string& name, const std::string& text) const {
    ASSERT_TRUE(write_text_atomically(dir_ / name, text));
  }
  void append(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((dir_ / name).parent_path());
    std::ofstream(dir_ / name, std::ios::app) << text;
  }
  const std::filesystem::path& dir() const { return dir_; }

 private:
  std::filesystem::path dir_;
  std::uint64_t sequence_ = 0;
};

}  // namespace granary::test
