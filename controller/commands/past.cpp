#include "controller/commands/past.hpp"

#include <fmt/format.h>

#include "controller/coupling/update.hpp"
#include "controller/run/file_handover.hpp"

namespace granary::commands {
namespace fs = std::filesystem;

Result<std::unique_ptr<Past>> past_of(const fs::path& dir) {
  if (!fs::exists(dir / "journal.jsonl"))
    return Error{fmt::format("{}: no campaign is there (no journal.jsonl).", dir.string())};
  GRANARY_TRY(pilot::Journal journal, pilot::Journal::copy_of(dir / "journal.jsonl"));
  auto past = std::make_unique<Past>();
  GRANARY_TRY(past->campaign, campaign::read_written_campaign(dir / "campaign.json"));
  const campaign::Campaign& campaign = past->campaign;
  const auto settings = run::coupling_settings(campaign);
  past->journal = std::move(journal);
  if (campaign.kind == campaign::Kind::coupled) {
    for (const pilot::Record& record : past->journal.records("coupling.event")) {
      GRANARY_TRY(const auto event, coupling::event_from_json(record.payload));
      past->coupling = coupling::update(past->coupling, event, settings).next;
    }
  }
  const auto machine = pilot::stated_machine(campaign.resources.nodes, campaign.resources.cores.value_or(1024));
  GRANARY_TRY(past->pilot, pilot::Pilot::open({dir, machine}, past->loop, past->launcher, past->journal));
  return past;
}

}  // namespace granary::commands
