// granary-agent: what runs on each node of a block. Started by the pilot through srun, never by a person:
//   granary-agent DIR [NODE]        (NODE: default what Slurm calls this node)
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "pilot/agent/guardian.hpp"
#include "pilot/agent/worker.hpp"

namespace {

using namespace granary;
using namespace granary::pilot;

int failed(const Error& error) {
  fmt::print(stderr, "granary-agent: {}\n", error.message);
  return static_cast<int>(error.exit);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 6 && std::string_view(argv[1]) == "--worker") {
    const auto end = run_worker({argv[2], argv[3], argv[4], static_cast<std::uint16_t>(std::atoi(argv[5]))});
    return end ? static_cast<int>(*end) : failed(end.error());
  }
  const char* node = argc == 3 ? argv[2] : std::getenv("SLURMD_NODENAME");
  if (argc < 2 || argc > 3 || node == nullptr)
    return failed({"usage: granary-agent DIR [NODE], in a step of Slurm; `granary` starts it"});
  const auto done = run_guardian(argv[1], node);
  return done ? 0 : failed(done.error());
}
