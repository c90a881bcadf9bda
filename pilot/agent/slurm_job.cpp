#include "pilot/agent/slurm_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <map>
#include <numeric>
#include <sstream>

#include "pilot/launch/run_program.hpp"
#include "pilot/protocol/tcp.hpp"

namespace granary::pilot {
namespace {

constexpr double kSlurmAnswers = 60.0;  ///< with a busy controller [s]
constexpr std::int64_t kMegabyte = 1 << 20;

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

Result<std::string> ask_slurm(const std::vector<std::string>& argv) {
  GRANARY_TRY(const ProgramOutput output, run_program(argv, "", kSlurmAnswers));
  if (output.exit_code == 0) return output.out;
  return Error{fmt::format("{} {}: {}", argv[0], argv[1], output.err), Exit::internal};
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) lines.push_back(line);
  return lines;
}

Result<std::vector<std::string>> unfold(const std::string& nodes) {
  GRANARY_TRY(const std::string text, ask_slurm({"scontrol", "show", "hostnames", nodes}));
  return lines_of(text);
}

/// What "scontrol -o show node" says of each node.
Result<std::map<std::string, std::string>> node_words(const std::string& nodes) {
  GRANARY_TRY(const std::string text, ask_slurm({"scontrol", "-o", "show", "node", nodes}));
  std::map<std::string, std::string> words;
  for (const std::string& line : lines_of(text)) words[word(line, "NodeName")] = line;
  return words;
}

/// Slurm counts hardware threads where it knows of them; we count cores.
Node node_of(const std::string& name, const NodeGroup& group, const std::string& words) {
  Node node;
  node.name = name;
  const int threads = std::max(1, std::atoi(word(words, "ThreadsPerCore").c_str()));
  node.cpus.resize(static_cast<std::size_t>(std::max(1, group.cpus / threads)));
  std::iota(node.cpus.begin(), node.cpus.end(), 0);
  const std::int64_t megabytes =
      group.memory_mb > 0 ? group.memory_mb : std::strtoll(word(words, "RealMemory").c_str(), nullptr, 10);
  node.memory_bytes = megabytes * kMegabyte;
  return node;
}

}  // namespace

std::string word(const std::string& line, const std::string& key) {
  std::istringstream in(line);
  for (std::string one; in >> one;)
    if (one.starts_with(key + "=")) return one.substr(key.size() + 1);
  return "";
}

int count_ids(const std::string& ids) {
  int count = 0;
  std::istringstream in(ids);
  for (std::string piece; std::getline(in, piece, ',');) {
    int first = 0, last = 0;
    const int found = std::sscanf(piece.c_str(), "%d-%d", &first, &last);
    if (found < 1 || first < 0) return 0;
    if (found == 1) last = first;
    if (last < first) return 0;
    count += last - first + 1;
  }
  return count;
}

std::vector<NodeGroup> node_groups(const std::string& job_words) {
  std::vector<NodeGroup> groups;
  std::istringstream in(job_words);
  for (std::string one; in >> one;) {
    if (one.starts_with("Nodes=")) groups.push_back({one.substr(6), 0, 0});
    if (groups.empty()) continue;
    if (one.starts_with("CPU_IDs=")) groups.back().cpus = count_ids(one.substr(8));
    if (one.starts_with("Mem=")) groups.back().memory_mb = std::strtoll(one.c_str() + 4, nullptr, 10);
  }
  std::erase_if(groups, [](const NodeGroup& group) { return group.cpus == 0; });
  return groups;
}

std::optional<double> wall_time_of(const std::string& text) {
  std::tm time = {};
  const char* end = strptime(text.c_str(), "%Y-%m-%dT%H:%M:%S", &time);
  if (end == nullptr || *end != '\0') return std::nullopt;
  time.tm_isdst = -1;
  return static_cast<double>(std::mktime(&time));
}

Result<SlurmJob> current_slurm_job() {
  SlurmJob job;
  job.id = variable("SLURM_JOB_ID");
  if (job.id.empty())
    return Error{
        "this is no job of Slurm (SLURM_JOB_ID is not set), and /resources/backend is \"slurm\". Start the campaign "
        "with "
        "`granary submit`, or inside of `salloc`; or run it here with --set /resources/backend=local."};
  GRANARY_TRY(const std::string job_words, ask_slurm({"scontrol", "-o", "-d", "show", "job", job.id}));
  const std::string list = word(job_words, "NodeList");
  GRANARY_TRY(const std::vector<std::string> names, unfold(list));
  GRANARY_TRY(const auto words, node_words(list));
  std::map<std::string, NodeGroup> group_of;
  for (const NodeGroup& group : node_groups(job_words)) {
    GRANARY_TRY(const std::vector<std::string> members, unfold(group.nodes));
    for (const std::string& name : members) group_of[name] = group;
  }
  for (const std::string& name : names) {
    const auto said = words.find(name);
    if (group_of.count(name) == 0 || said == words.end())
      return Error{fmt::format("scontrol says nothing of the cores that job {} has on {}", job.id, name),
                   Exit::internal};
    job.machine.nodes.push_back(node_of(name, group_of[name], said->second));
  }
  if (job.machine.nodes.empty()) return Error{fmt::format("job {} has no nodes", job.id), Exit::internal};
  const auto ours = words.find(variable("SLURMD_NODENAME"));
  job.address = ours != words.end() ? word(ours->second, "NodeAddr") : "";
  if (job.address.empty()) job.address = host_name();
  job.end_time = wall_time_of(word(job_words, "EndTime"));
  return job;
}

}  // namespace granary::pilot
