// Any bytes as a case file. What read_case() accepts must print and read back to the same case, and start to run.
#include <cstdint>
#include <cstdio>

#include "common/json/io.hpp"
#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/output/summary.hpp"
#include "pbm_solver/time/simulation.hpp"
#include "tests/fuzz/fuzz_support.hpp"

namespace {

using namespace granary;
using fuzz::demand;

constexpr std::size_t kMostClasses = 64, kMostCompartments = 4, kMostDemClasses = 16;  // else a step takes too long

void comes_back(const pbm::PbmCase& c) {
  const std::string written = json::dump(pbm::to_json(c));
  const auto document = json::parse(written, "written.json");
  demand(document.has_value(), "an accepted case prints as JSON");
  const auto again = pbm::read_case(*document, "written.json");
  if (!again) std::fprintf(stderr, "%s\n%s\n", again.error().message.c_str(), written.c_str());
  demand(again.has_value(), "what is printed of an accepted case is accepted");
  demand(json::dump(pbm::to_json(*again)) == written, "a case reads back as it was");
}

bool is_small(const pbm::PbmCase& c) {
  return static_cast<std::size_t>(c.grid.bins[0]) * static_cast<std::size_t>(c.grid.bins[1]) <= kMostClasses &&
         static_cast<std::size_t>(c.compartments.count) <= kMostCompartments &&
         (!c.dem || c.dem->diameter.size() <= kMostDemClasses);
}

/// A step may fail, with a message; it may not crash, hang or leave a state that is not finite.
void starts(const pbm::PbmCase& c) {
  const pbm::ClassGrid grid(c.grid);
  const pbm::Snapshot start = pbm::initial_snapshot(c, grid);
  pbm::summarize(start, c, grid);
  pbm::Alone exchange(c.compartments.count);
  pbm::Simulation simulation(c, start, exchange, 1);
  const auto reached = simulation.advance(c.end_time, [] { return false; });
  if (!reached) return demand(!reached.error().message.empty(), "a failed step says why");
  pbm::summarize(simulation.snapshot(), c, grid);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto document = json::parse({reinterpret_cast<const char*>(data), size}, "case.json");
  if (!document) return demand(!document.error().message.empty(), "a refusal says why"), 0;
  const auto c = pbm::read_case(*document, "case.json");
  if (!c) return demand(!c.error().message.empty(), "a refusal says why"), 0;
  comes_back(*c);
  if (is_small(*c)) starts(*c);
  return 0;
}
