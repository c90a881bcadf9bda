#include "controller/commands/watched.hpp"

#include <fmt/format.h>

#include <chrono>
#include <thread>

#include "controller/commands/status.hpp"

namespace granary::commands {
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

namespace {
constexpr std::chrono::seconds kCampaignAppears{2};
}

Result<watch::Watcher> watcher_of(const fs::path& dir) {
  const auto clock = [start = Clock::now()] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  watch::Watcher watcher(fs::absolute(dir).lexically_normal(),
                         {[dir] { return campaign_status(dir); }, [dir] { return queue_status(dir); }, clock});
  for (const auto until = Clock::now() + kCampaignAppears; !watcher.anything_there();) {
    if (Clock::now() > until)
      return Error{
          fmt::format("{}: no campaign is there (neither campaign.json nor journal.jsonl). Start one: granary run "
                      "WORKFLOW --dir {}",
                      dir.string(), dir.string())};
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return watcher;
}

}  // namespace granary::commands
