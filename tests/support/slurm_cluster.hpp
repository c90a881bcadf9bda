// A real Slurm of virtual nodes on this machine, for tests (slurm_local.sh beside this file does it).
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>

#include "common/files.hpp"
#include "pilot/launch/run_program.hpp"

namespace granary::test {

class SlurmCluster {
 public:
  /// Starts it and lets the programs of this process use it. why_not() says why it does not run.
  SlurmCluster(int nodes, int cores) {
    std::filesystem::remove_all(dir_);
    const auto output = run({"start", dir_, std::to_string(nodes), std::to_string(cores)}, 60.0);
    if (!output || output->exit_code != 0) {
      why_not_ = output ? output->err : output.error().message;
      return;
    }
    setenv("SLURM_CONF", (dir_ + "/etc/slurm.conf").c_str(), 1);
    // All nodes are this machine, and have fewer CPUs than they say.
    setenv("OMPI_MCA_oob_tcp_if_include", "lo", 1);
    setenv("OMPI_MCA_btl_tcp_if_include", "lo", 1);
    setenv("OMPI_MCA_mpi_yield_when_idle", "1", 1);
    setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
    setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
  }
  ~SlurmCluster() {
    (void)run({"stop", dir_}, 30.0);
    std::error_code ignored;
    std::filesystem::remove_all(dir_, ignored);
  }

  const std::string& why_not() const { return why_not_; }
  /// Whether each node has a host name of its own: not where this user may not make namespaces.
  bool has_own_hosts() const { return read_text(dir_ + "/ns").value_or("").starts_with("yes"); }
  /// A power cut: everything on the node is gone at once.
  void crash(const std::string& node) const { EXPECT_EQ(run({"crash-node", dir_, node}, 20.0)->exit_code, 0); }
  void boot(const std::string& node) const { EXPECT_EQ(run({"boot-node", dir_, node}, 20.0)->exit_code, 0); }
  /// Until no job is left and every node is idle.
  void wait_until_idle() const {
    for (int k = 0; k < 300; ++k) {
      const auto jobs = pilot::run_program({"squeue", "-h"}, "", 10.0);
      const auto nodes = pilot::run_program({"sinfo", "-h", "-N", "-o", "%T"}, "", 10.0);
      const bool busy = !jobs || !nodes || !jobs->out.empty() || nodes->out.find_first_of("*") != std::string::npos;
      if (!busy && nodes->out.find("ing") == std::string::npos && nodes->out.find("alloc") == std::string::npos &&
          nodes->out.find("down") == std::string::npos)
        return;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    ADD_FAILURE() << "the cluster does not become idle";
  }

 private:
  static Result<pilot::ProgramOutput> run(std::vector<std::string> argv, double timeout_s) {
    argv.insert(argv.begin(), std::string(GRANARY_SOURCE_DIR) + "/tests/support/slurm_local.sh");
    return pilot::run_program(argv, "", timeout_s);
  }

  std::string dir_ = "/tmp/granary_slurm_" + std::to_string(getpid());
  std::string why_not_;
};

}  // namespace granary::test
