#include "controller/commands/finish.hpp"

#include "controller/report/report.hpp"
#include "controller/run/collect.hpp"
#include "controller/run/provenance.hpp"

namespace granary::commands {

Result<CampaignResults> finish(Session& session, const run::FileHandover& handover, const coupling::State& state) {
  run::RunRecord record;
  record.state = state;
  record.ends = session.pilot->ends();
  record.timeline = session.pilot->timeline();
  record.estimation = session.journal.records("estimation.");
  record.cores = session.machine.n_cores();
  record.wall = session.pilot->now();
  record.started =
      run::iso_time(session.journal.first_wall_time().value_or(session.loop.wall_time() - session.loop.now()));
  record.finished = run::iso_time(session.loop.wall_time());
  GRANARY_TRY(CampaignResults results, run::collect(session.campaign, handover, session.dir, record));
  GRANARY_CHECK(write_results(results, session.dir / "results.h5"));
  if (session.campaign.outputs.report)
    GRANARY_CHECK(report::write_report(session.dir / "results.h5", session.dir / "report.html"));
  return results;
}

}  // namespace granary::commands
