#include "controller/commands/past.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "controller/coupling/update.hpp"
#include "controller/run/file_handover.hpp"

namespace granary::commands {
namespace fs = std::filesystem;

namespace {

/// The machine of the last pilot that lived here; if none did, what the workflow asks for.
pilot::Machine last_machine(const pilot::Journal& journal, const campaign::Resources& resources) {
  pilot::Machine machine;
  const std::vector<pilot::Record> openings = journal.records("pilot.open");
  if (!openings.empty()) {
    for (const json::Value& node : openings.back().payload["nodes"].items_or_none()) {
      pilot::Node& last = machine.nodes.emplace_back();
      last.name = node.text_or("name", "");
      for (std::int64_t cpu = 0; cpu < node.integer_or("cores", 0); ++cpu) last.cpus.push_back(static_cast<int>(cpu));
    }
  }
  if (machine.n_cores() > 0) return machine;
  return pilot::stated_machine(resources.nodes, resources.cores.value_or(1024));
}

}  // namespace

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
  pilot::Machine machine = last_machine(past->journal, campaign.resources);
  GRANARY_TRY(past->pilot, pilot::Pilot::open({dir, std::move(machine)}, past->loop, past->launcher, past->journal));
  return past;
}

}  // namespace granary::commands
