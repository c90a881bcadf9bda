// What pilot and agents say to each other: JSON objects on a Channel. Pure. The list of them is in docs/slurm.md.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "pilot/launch/launcher.hpp"

namespace granary::pilot {

/// What an agent found on its node.
struct AgentReport {
  std::string host;
  std::vector<int> cpus;  ///< the operating system's number of each core we may use there
  std::int64_t memory_bytes = 0;
  int pid = 0;
};

json::Value to_json(const AgentReport& report);
Result<AgentReport> report_from_json(const json::Value& value);

json::Value to_json(AttemptId attempt);
Result<AttemptId> attempt_from_json(const json::Value& value);

/// `launch.cores` are the node's own: 0, 1, ...
json::Value to_json(const Launch& launch);
Result<Launch> launch_from_json(const json::Value& value);

json::Value to_json(const RunEnd& end);
RunEnd end_from_json(const json::Value& value);

json::Value to_json(const std::vector<int>& numbers);
/// Numbers below 0 or beyond `most` are none of ours: nothing then.
Result<std::vector<int>> numbers_from_json(const json::Value& value, int most);

}  // namespace granary::pilot
