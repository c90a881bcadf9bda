#include "pilot/launch/command.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>

#include "pilot/launch/marked.hpp"

namespace granary::pilot {
namespace {

bool is_file(const std::filesystem::path& file) {
  struct stat status = {};
  return stat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode);
}

bool is_executable(const std::filesystem::path& file) { return is_file(file) && access(file.c_str(), X_OK) == 0; }

void set(std::vector<std::string>& env, std::string_view key, std::string_view value) {
  const auto is_key = [key](const std::string& entry) {
    return entry.size() > key.size() && entry[key.size()] == '=' && entry.compare(0, key.size(), key) == 0;
  };
  std::string entry = fmt::format("{}={}", key, value);
  if (const auto found = std::find_if(env.begin(), env.end(), is_key); found != env.end()) {
    *found = std::move(entry);
  } else {
    env.push_back(std::move(entry));
  }
}

}  // namespace

Result<std::string> find_executable(const std::string& command, const std::filesystem::path& dir,
                                    std::string_view path) {
  if (command.find('/') != std::string::npos) {
    const std::filesystem::path file = dir / command;
    if (is_executable(file)) return file.string();
    return Error{
        fmt::format("{}: {}", file.string(), is_file(file) ? "is not executable (chmod +x)" : "no such program"),
        Exit::task_failed};
  }
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find(':', begin), path.size());
    const std::filesystem::path folder(path.substr(begin, end - begin));
    if (!folder.empty() && is_executable(folder / command)) return (folder / command).string();
    begin = end + 1;
  }
  return Error{fmt::format("{}: no such program in PATH ({}). Install it, or give its full path.", command, path),
               Exit::task_failed};
}

std::string_view variable(const std::vector<std::string>& env, std::string_view key) {
  for (const std::string& entry : env) {
    if (entry.size() > key.size() && entry[key.size()] == '=' && entry.compare(0, key.size(), key) == 0) {
      return std::string_view(entry).substr(key.size() + 1);
    }
  }
  return {};
}

std::vector<std::string> environment_of(const Launch& launch, const std::vector<std::string>& ours) {
  std::vector<std::string> env = ours;
  set(env, "OMP_NUM_THREADS", std::to_string(launch.spec.threads));
  // "cores" are those of the process's affinity mask: exactly the task's, or the rank's.
  set(env, "OMP_PLACES", "cores");
  set(env, "OMP_PROC_BIND", launch.spec.threads > 1 ? "close" : "false");
  set(env, kMarkVariable, launch.mark);
  set(env, "GRANARY_TASK", launch.spec.name);
  set(env, "GRANARY_ATTEMPT", std::to_string(launch.attempt.number));
  for (const auto& [key, value] : launch.spec.env) set(env, key, value);
  return env;
}

bool uses_mpirun(const TaskSpec& spec) { return spec.mpi || spec.ranks > 1; }

bool is_on_several_hosts(const Launch& launch) {
  const auto other = [&](const HostCores& one) { return one.host != launch.hosts.front().host; };
  return std::any_of(launch.hosts.begin(), launch.hosts.end(), other);
}

std::vector<std::string> mpirun_argv(const Launch& launch, const std::vector<std::string>& env,
                                     const std::filesystem::path& rank_file, bool as_root) {
  std::vector<std::string> argv{"mpirun"};
  if (as_root) argv.emplace_back("--allow-run-as-root");
  argv.insert(argv.end(), {"-n", std::to_string(launch.spec.ranks)});
  if (!is_on_several_hosts(launch)) {
    // On one node, shared memory is all that is needed; not looking for networks makes the start three times faster.
    // Who sets these in the environment knows better.
    if (variable(env, "OMPI_MCA_pml").empty() && variable(env, "OMPI_MCA_btl").empty())
      argv.insert(argv.end(), {"--mca", "pml", "ob1", "--mca", "btl", "self,vader"});
    // Inside a step of Slurm, mpirun would take the whole job for its machine and find it full.
    if (!variable(env, "SLURM_JOB_ID").empty())
      argv.insert(argv.end(), {"--mca", "ras", "^slurm", "--mca", "plm", "isolated"});
  } else {
    // Only these: mpirun would start a daemon on every node of the job, and wait long for one that is dead.
    std::string hosts;
    for (const HostCores& one : launch.hosts)
      hosts += fmt::format("{}{}:{}", hosts.empty() ? "" : ",", one.host, one.cpus.size());
    argv.insert(argv.end(), {"--host", hosts});
  }
  if (launch.cores.size() < launch.spec.ranks && launch.hosts.empty()) {
    argv.insert(argv.end(),
                {"--oversubscribe", "--bind-to", "none"});  // more ranks than cores: they share the inherited mask
  } else {
    // mpirun ignores its own affinity mask: without this, two at once would both pin their ranks from core 0 on.
    argv.insert(argv.end(), {"--mca", "rmaps_rank_file_physical", "1", "--rankfile", rank_file.string()});
  }
  argv.insert(argv.end(), launch.spec.command.begin(), launch.spec.command.end());
  return argv;
}

void prepare_for_several_hosts(std::vector<std::string>& env) {
  // mpirun starts its daemons with srun: they share the nodes with everything else, and a step's own idea of how many
  // tasks a node takes (one: the agent) is not the job's.
  set(env, "SLURM_OVERLAP", "1");
  const std::string cpus(variable(env, "SLURM_JOB_CPUS_PER_NODE"));
  if (!cpus.empty()) set(env, "SLURM_TASKS_PER_NODE", cpus);
}

std::string rank_file_text(const Launch& launch, const Machine& machine) {
  std::vector<std::pair<std::string, int>> places;  ///< host and CPU of each core
  const bool several = is_on_several_hosts(launch);
  for (const HostCores& one : launch.hosts)
    for (const int cpu : one.cpus) places.emplace_back(several ? one.host : "localhost", cpu);
  if (launch.hosts.empty())
    launch.cores.for_each([&](int core) { places.emplace_back("localhost", machine.cpu_of(core)); });

  std::string text;
  const auto threads = static_cast<std::size_t>(launch.spec.threads);
  for (std::size_t rank = 0; (rank + 1) * threads <= places.size(); ++rank) {
    std::string slots;
    for (std::size_t k = 0; k < threads; ++k)
      slots += fmt::format("{}{}", k > 0 ? "," : "", places[rank * threads + k].second);
    text += fmt::format("rank {}={} slot={}\n", rank, places[rank * threads].first, slots);
  }
  return text;
}

}  // namespace granary::pilot
