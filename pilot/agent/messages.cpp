#include "pilot/agent/messages.hpp"

#include <fmt/format.h>

#include "pilot/task/spec_json.hpp"

namespace granary::pilot {
namespace {

constexpr int kMostCpus = 1 << 16;  ///< on one node

std::vector<std::filesystem::path> paths_in(const json::Value& value) {
  std::vector<std::filesystem::path> paths;
  for (const json::Value& item : value.items_or_none())
    if (item.is_string()) paths.emplace_back(item.as_string());
  return paths;
}

}  // namespace

json::Value to_json(const std::vector<int>& numbers) {
  json::Value list = json::Value::array();
  for (const int number : numbers) list.push(number);
  return list;
}

Result<std::vector<int>> numbers_from_json(const json::Value& value, int most) {
  std::vector<int> numbers;
  for (const json::Value& item : value.items_or_none()) {
    if (!item.is_integer() || item.as_integer() < 0 || item.as_integer() >= most)
      return Error{fmt::format("a list of numbers from 0 to {} is wanted", most - 1)};
    numbers.push_back(static_cast<int>(item.as_integer()));
  }
  return numbers;
}

json::Value to_json(const AgentReport& report) {
  return json::Value::object({{"host", report.host},
                              {"cpus", to_json(report.cpus)},
                              {"memory_bytes", report.memory_bytes},
                              {"pid", report.pid}});
}

Result<AgentReport> report_from_json(const json::Value& value) {
  AgentReport report;
  report.host = value.text_or("host", "");
  GRANARY_TRY(report.cpus, numbers_from_json(value["cpus"], kMostCpus));
  report.memory_bytes = value.integer_or("memory_bytes", 0);
  report.pid = static_cast<int>(value.integer_or("pid", 0));
  if (report.host.empty() || report.cpus.empty()) return Error{"an agent without a host name or without cores"};
  return report;
}

json::Value to_json(AttemptId attempt) { return json::Value::array().push(attempt.task.value).push(attempt.number); }

Result<AttemptId> attempt_from_json(const json::Value& value) {
  const auto& pair = value.items_or_none();
  if (pair.size() != 2 || !pair[0].is_integer() || !pair[1].is_integer()) return Error{"no attempt is named"};
  return AttemptId{{static_cast<int>(pair[0].as_integer())}, static_cast<int>(pair[1].as_integer())};
}

json::Value to_json(const Launch& launch) {
  json::Value value = json::Value::object({{"id", to_json(launch.attempt)},
                                           {"spec", to_json(launch.spec)},
                                           {"dir", launch.dir.string()},
                                           {"cores", to_json(launch.cores.list())},
                                           {"mark", launch.mark}});
  if (launch.hosts.empty()) return value;
  json::Value hosts = json::Value::array();
  for (const HostCores& one : launch.hosts)
    hosts.push(json::Value::object({{"host", one.host}, {"cpus", to_json(one.cpus)}}));
  return value.set("hosts", std::move(hosts));
}

Result<Launch> launch_from_json(const json::Value& value) {
  Launch launch;
  GRANARY_TRY(launch.attempt, attempt_from_json(value["id"]));
  launch.spec = spec_from_json(value["spec"]);
  launch.dir = value.text_or("dir", "");
  GRANARY_TRY(launch.cores, numbers_from_json(value["cores"], kMostCpus));
  launch.mark = value.text_or("mark", "");
  for (const json::Value& item : value["hosts"].items_or_none()) {
    HostCores one;
    one.host = item.text_or("host", "");
    GRANARY_TRY(one.cpus, numbers_from_json(item["cpus"], kMostCpus));
    launch.hosts.push_back(std::move(one));
  }
  if (launch.spec.command.empty() || launch.mark.empty() || !launch.dir.is_absolute())
    return Error{"a task without command, mark or folder"};
  return launch;
}

json::Value to_json(const RunEnd& end) {
  json::Value value = json::Value::object({{"exit_code", end.exit_code}, {"cpu_s", end.cpu_s}});
  if (end.signal != 0) value.set("signal", end.signal);
  if (!end.not_started.empty()) value.set("not_started", end.not_started);
  if (end.missing.empty()) return value;
  json::Value missing = json::Value::array();
  for (const auto& file : end.missing) missing.push(file.string());
  return value.set("missing", std::move(missing));
}

RunEnd end_from_json(const json::Value& value) {
  RunEnd end;
  end.exit_code = static_cast<int>(value.integer_or("exit_code", -1));
  end.signal = static_cast<int>(value.integer_or("signal", 0));
  end.cpu_s = value.number_or("cpu_s", 0.0);
  end.missing = paths_in(value["missing"]);
  end.not_started = value.text_or("not_started", "");
  return end;
}

}  // namespace granary::pilot
