#include "controller/run/provenance.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <ctime>
#include <fstream>
#include <sstream>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "common/version.hpp"
#include "pilot/launch/run_program.hpp"

namespace granary::run {
namespace fs = std::filesystem;
namespace {

/// The first line a program prints when asked for its version; "not found" if it does not run.
std::string version_line(const std::vector<std::string>& argv) {
  const auto output = pilot::run_program(argv, "", 20.0);
  if (!output || output->exit_code != 0) return "not found";
  return output->out.substr(0, output->out.find('\n'));
}

std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

std::string host() {
  char name[256] = "unknown";
  ::gethostname(name, sizeof name - 1);
  const double gigabytes =
      static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGE_SIZE)) / 1e9;
  return fmt::format("{}: {} cores of {}, {:.0f} GB", name, ::sysconf(_SC_NPROCESSORS_ONLN), processor(), gigabytes);
}

}  // namespace

std::string iso_time(double wall_time) {
  const auto seconds = static_cast<std::time_t>(wall_time);
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

Result<Provenance> provenance_of(const campaign::Campaign& campaign, const fs::path& dir,
                                 const coupling::State& state) {
  Provenance provenance;
  provenance.name = campaign.name;
  provenance.kind = "coupled";
  provenance.version = version();
  provenance.revision = revision();
  provenance.host = host();
  GRANARY_TRY(provenance.campaign_json, read_text(dir / "campaign.json"));
  provenance.versions = {{"granary", fmt::format("{} ({})", version(), revision())},
                         {"granary-dem", version_line({(program_folder() / "granary-dem").string(), "--version"})},
                         {"granary-pbm", version_line({(program_folder() / "granary-pbm").string(), "--version"})},
                         {"mpirun", version_line({"mpirun", "--version"})},
                         {"gnuplot", version_line({"gnuplot", "--version"})}};
  for (const auto& over : state.bursts) {
    if (over.burst.kind != coupling::Kind::dem) continue;
    GRANARY_TRY(const auto burst, json::read_file(dir / "bursts" / over.burst.folder() / "case.json"));
    provenance.seeds.push_back(
        {fmt::format("dem burst {} attempt {}", over.burst.round, over.attempt), burst.integer_or("seed", 0)});
  }
  return provenance;
}

}  // namespace granary::run
