// Campaigns of small tasks for agents, that tell if anything ran twice or doubled; and agents to be killed.
#pragma once

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <thread>

#include "common/files.hpp"
#include "common/json/io.hpp"

namespace granary::test {

namespace fs = std::filesystem;

inline bool wait_until(const std::function<bool()>& done, double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!done() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return done();
}

/// A task that holds a lock as long as any process of it lives (the kernel gives it back when the last one is gone, how
/// ever that ends): a second copy that runs at the same time fails with exit code 9. It writes down its attempt when it
/// begins and when it has done its work; with it, a descendant in a session of its own.
inline json::Value honest_task(const std::string& name, double seconds) {
  std::ostringstream script;
  script << "echo begin $GRANARY_ATTEMPT >> " << name << ".log; setsid sleep " << seconds << " & sleep " << seconds
         << "; wait; echo done $GRANARY_ATTEMPT >> " << name << ".log";
  return json::Value::object(
      {{"name", name},
       {"command", std::vector<std::string>{"flock", "-n", "-E", "9", name + ".lock", "/bin/sh", "-c", script.str()}}});
}

/// Ranks on two nodes; rank 0 tells when all are there, and when its work is done.
inline json::Value honest_mpi_task(const std::string& name, double seconds) {
  std::ostringstream script;
  script << "test \"$OMPI_COMM_WORLD_RANK\" = 0 && echo begin $GRANARY_ATTEMPT >> " << name << ".log; hostname >> "
         << name << ".hosts; sleep " << seconds << "; test \"$OMPI_COMM_WORLD_RANK\" = 0 || exit 0; echo done "
         << "$GRANARY_ATTEMPT >> " << name << ".log";
  return json::Value::object({{"name", name},
                              {"ranks", 2},
                              {"nodes", 2},
                              {"priority", 1},
                              {"command", std::vector<std::string>{"/bin/sh", "-c", script.str()}}});
}

inline json::Value honest_tasks(int count, double seconds) {
  json::Value tasks = json::Value::array();
  for (int k = 0; k < count; ++k) tasks.push(honest_task("t" + std::to_string(k), seconds));
  return tasks;
}

inline fs::path write_workflow(const fs::path& file, const std::string& name, json::Value resources,
                               json::Value tasks) {
  const auto written = json::write_file(file, json::Value::object({{"granary", 1},
                                                                   {"kind", "tasks"},
                                                                   {"name", name},
                                                                   {"resources", std::move(resources)},
                                                                   {"tasks", std::move(tasks)}}));
  EXPECT_TRUE(written.has_value());
  return file;
}

inline std::string text_in(const fs::path& file) { return read_text(file).value_or(""); }

inline int count_in(const std::string& text, const std::string& wanted) {
  int count = 0;
  for (std::size_t at = 0; (at = text.find(wanted, at)) != std::string::npos; at += wanted.size()) ++count;
  return count;
}

/// Records of the journal, in order.
inline std::vector<json::Value> records_of(const fs::path& dir) {
  std::vector<json::Value> records;
  std::ifstream file(dir / "journal.jsonl");
  for (std::string line; std::getline(file, line);)
    if (const auto record = json::parse(line, "journal")) records.push_back(*record);
  return records;
}

/// Each of the tasks t0, t1, ... did its work, was recorded as finished exactly once, and was never started after that.
/// What was done twice was lost with its agent before its end could be told.
inline void expect_each_finished_once(const fs::path& dir, int count) {
  std::map<std::int64_t, int> finished;
  std::set<std::int64_t> stopped;  // by the pilot: whatever its exit code, it goes on later
  std::size_t lost = 0;
  for (const json::Value& record : records_of(dir)) {
    const json::Value& payload = record["payload"];
    const std::string kind = record.text_or("kind", "");
    const std::int64_t id = payload.integer_or("id", -1);
    lost += kind == "task.lost";
    if (kind == "task.stop") stopped.insert(id);
    const bool was_stopped = kind == "task.exit" && stopped.erase(id) > 0;
    if (kind == "task.exit" && !was_stopped && payload.integer_or("exit_code", -1) == 0) ++finished[id];
    if (kind == "task.place") {
      EXPECT_EQ(finished[id], 0) << "task " << id << " had finished";
    }
  }
  for (const auto& [id, times] : finished) EXPECT_LE(times, 1) << "task " << id;
  int done = 0;
  for (int k = 0; k < count; ++k) {
    const std::string log = text_in(dir / ("t" + std::to_string(k) + ".log"));
    EXPECT_EQ(finished[k], 1) << "t" << k;
    EXPECT_GE(count_in(log, "done"), 1) << "t" << k << ": " << log;
    done += count_in(log, "done");
  }
  EXPECT_LE(done, count + static_cast<int>(lost));
}

/// Wall times [s] of the journal's records of a kind.
inline std::vector<double> times_of(const fs::path& dir, const std::string& kind) {
  std::vector<double> times;
  for (const json::Value& record : records_of(dir))
    if (record.text_or("kind", "") == kind) times.push_back(record.number_or("wall_s", 0.0));
  return times;
}

inline double wall_now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

struct AgentPids {
  int guardian = 0, worker = 0;
};

/// Whether this is a process that waits for a task: it has its maker's command line, but nothing open except /dev/null
/// and the task's output to be.
inline bool is_prepared(const fs::path& process) {
  std::error_code error;
  return fs::read_symlink(process / "fd/0", error) == "/dev/null" && !fs::exists(process / "fd/4", error);
}

/// The agent of a node of a campaign, as this machine sees its two processes.
inline AgentPids agent_of(const fs::path& dir, const std::string& node) {
  AgentPids pids;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const int pid = std::atoi(entry.path().filename().c_str());
    if (pid <= 0) continue;
    std::string words = text_in(entry.path() / "cmdline"), env = text_in(entry.path() / "environ");
    std::replace(words.begin(), words.end(), '\0', ' ');
    const std::string worker = "granary-agent --worker " + dir.string() + " " + node + " ";
    if (words.starts_with(worker) && !is_prepared(entry.path())) pids.worker = pid;
    const bool is_guardian =
        words.find("granary-agent " + dir.string() + " ") != std::string::npos && !words.starts_with("srun");
    const bool named = words.ends_with(" " + node + " ") ||
                       env.find("SLURMD_NODENAME=" + node + std::string(1, '\0')) != std::string::npos;
    if (is_guardian && named) pids.guardian = pid;
  }
  return pids;
}

/// Living processes of the campaign's tasks: those that hold a lock of theirs.
inline int processes_of_tasks(const fs::path& dir) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    if (std::atoi(entry.path().filename().c_str()) <= 0) continue;
    std::error_code error;
    const bool there = fs::read_symlink(entry.path() / "cwd", error) == dir;
    count += there && text_in(entry.path() / "environ").find("GRANARY_MARK=") != std::string::npos;
  }
  return count;
}

}  // namespace granary::test
