#include "controller/bench/pilot_table.hpp"

#include <fmt/format.h>

namespace granary::bench {
namespace {

using json::Value;

std::string row(const std::string& what, const std::string& value, const std::string& target) {
  return fmt::format("{:<46} {:>24}   {}\n", what, value, target);
}

std::string percent(const Value& share) {
  return share.is_number() ? fmt::format("{:.1f} %", 100.0 * share.as_number()) : "-";
}

std::string core_use_rows(const Value& d, const std::string& key, const std::string& program) {
  std::string text = fmt::format("core use, tasks of {}\n", program);
  for (const auto& [seconds, target] : {std::pair{"0.5", ">= 99 %"}, {"0.1", ">= 98 %"}, {"0.01", ">= 90 %"}}) {
    text += row(fmt::format("  of {} s", seconds), percent(d[key][seconds]), target);
    text += row("    bare posix_spawn; processes prepared",
                fmt::format("{}; {}", percent(d[key + "_of_bare_starts"][seconds]),
                            percent(d[key + "_of_prepared_starts"][seconds])),
                "");
  }
  return text;
}

std::string local_table(const Value& d) {
  std::string text = fmt::format("This machine, {} core(s)\n", d.integer_or("cores", 0));
  text += row("", "measured", "target");
  text += row(fmt::format("{} tasks of /bin/true", d.integer_or("tasks", 0)),
              fmt::format("{:.0f} /s", d.number_or("throughput_per_s", 0.0)), ">= 1500 /s");
  text +=
      row("  bare posix_spawn, as many in flight", fmt::format("{:.0f} /s", d.number_or("spawn_limit_per_s", 0.0)), "");
  text += row("  of it", fmt::format("{:.2f} x", d.number_or("ratio", 0.0)), ">= 0.75 x");
  text += row("one task, submit to done", fmt::format("{:.2f} ms", d.number_or("submit_to_done_ms", 0.0)), "<= 2 ms");
  text += row(
      "dispatch: core freed to next program, p50 / p99",
      fmt::format("{:.2f} / {:.2f} ms", d["dispatch_ms"].number_or("p50", 0.0), d["dispatch_ms"].number_or("p99", 0.0)),
      "<= 1 / 5 ms");
  text += core_use_rows(d, "core_use", "/bin/sleep") +
          core_use_rows(d, "core_use_static", "a sleep that is linked statically");
  text += row("a filler gives way to a ready task, p50 / p99",
              fmt::format("{:.2f} / {:.2f} ms", d["filler_gives_way_ms"].number_or("p50", 0.0),
                          d["filler_gives_way_ms"].number_or("p99", 0.0)),
              "<= 10 ms");
  text += row("start-up to first task done", fmt::format("{:.0f} ms", d.number_or("startup_ms", 0.0)), "<= 50 ms");
  text += row("idle pilot",
              fmt::format("{:.2f} %, {:.1f} MB", 100.0 * d["idle"].number_or("core_share", 0.0),
                          d["idle"].number_or("resident_mb", 0.0)),
              "<= 0.5 %, 20 MB");
  text += row("files per task", fmt::format("{:.3g}", d.number_or("files_per_task", 0.0)), "<= 1");
  if (const Value& mpi = d["mpi_ms"]; mpi.is_object()) {
    const double bare = mpi.number_or("bare", 0.0);
    text += row("task with mpirun on one node", fmt::format("{:.0f} ms", mpi.number_or("task", 0.0)),
                fmt::format("mpirun alone ({:.0f} ms) + 2 ms", bare));
  } else {
    text += row("task with mpirun on one node", "-", d.text_or("mpi_ms_why", ""));
  }
  for (const Value& resume : d["resume"].items_or_none()) {
    text += row(fmt::format("{} resume, 100 000 finished, {:.0f} MB journal", resume.text_or("which", ""),
                            1e-6 * resume.number_or("journal_bytes", 0.0)),
                fmt::format("{:.2f} s, {:.0f} MB", resume.number_or("seconds", 0.0),
                            resume.number_or("resident_growth_mb", 0.0)),
                "<= 1 s");
  }
  return text;
}

std::string slurm_table(const Value& slurm) {
  if (!slurm.is_object()) return "";
  return row("on Slurm, tasks through agents", fmt::format("{:.0f} /s", slurm.number_or("agent_per_s", 0.0)),
             fmt::format(">= 30 x srun steps ({:.0f} /s): {:.0f} x", slurm.number_or("srun_per_s", 0.0),
                         slurm.number_or("ratio", 0.0)));
}

std::string simulation_table(const Value& simulation) {
  std::string text = "\nSimulated: the same scheduler, journal and life cycle on virtual time\n";
  text += fmt::format("{:>8} {:>6} {:>9} {:>12} {:>11} {:>10} {:>12} {:>12} {:>9}\n", "nodes", "cores", "tasks",
                      "placements/s", "us CPU each", "B a task", "makespan s", "lower bound", "core use");
  for (const Value& run : simulation["scaling"].items_or_none()) {
    text += fmt::format("{:>8} {:>6} {:>9} {:>12.0f} {:>11.1f} {:>10.0f} {:>12.0f} {:>12.0f} {:>9}\n",
                        run.integer_or("nodes", 0), run.integer_or("cores", 0), run.integer_or("tasks", 0),
                        run.number_or("placements_per_s", 0.0), 1e6 * run.number_or("cost_per_task_s", 0.0),
                        run.number_or("bytes_per_task", 0.0), run.number_or("makespan_s", 0.0),
                        run.number_or("lower_bound_s", 0.0), percent(run["core_use"]));
  }
  text += fmt::format("targets: >= 100000 placements/s, <= 1024 B a task, cost a task within 2 x (here {:.2f} x)\n",
                      simulation.number_or("cost_growth", 0.0));
  return text;
}

}  // namespace

std::string pilot_table(const Value& document) {
  std::string text;
  if (document.find("throughput_per_s") != nullptr) text += local_table(document) + slurm_table(document["slurm"]);
  if (document["simulate"].is_object()) text += simulation_table(document["simulate"]);
  return text;
}

}  // namespace granary::bench
