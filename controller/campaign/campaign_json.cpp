#include "controller/campaign/campaign.hpp"

#include <algorithm>
#include <cctype>

#include "common/json/io.hpp"
#include "common/json/reader.hpp"
#include "controller/campaign/campaign_schema.hpp"
#include "controller/campaign/checks.hpp"
#include "controller/campaign/overrides.hpp"
#include "controller/campaign/pointer.hpp"
#include "controller/campaign/reread.hpp"
#include "controller/campaign/sections.hpp"
#include "pilot/schedule/check_tasks.hpp"
#include "pilot/schedule/machine.hpp"
#include "pilot/task/spec_json.hpp"

namespace granary::campaign {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kFormat = 1;

void read_version(json::Reader& root) {
  const json::Value* written = root.raw("granary");
  if (written == nullptr)
    root.problem("granary", "it is missing: the version of the workflow's format.", R"(Add "granary": 1.)");
  else if (!written->is_integer() || written->as_integer() != kFormat)
    root.problem("granary", "this is not a version of the workflow's format that is known here.", "It must be 1.");
}

std::optional<Kind> read_kind(json::Reader& root) {
  const json::Value* written = root.raw("kind");
  if (written != nullptr && written->is_string()) {
    const std::string& kind = written->as_string();
    if (kind == "coupled") return Kind::coupled;
    if (kind == "tasks") return Kind::tasks;
    if (kind == "sweep") return Kind::sweep;
    if (kind == "circuit") {
      root.problem("kind", "not in this version.", "It must be one of: coupled, tasks, sweep.");
      return std::nullopt;
    }
  }
  root.choice("kind", {"coupled", "tasks", "sweep"});
  return std::nullopt;
}

/// The name becomes the name of folders and jobs.
std::string read_name(json::Reader& root) {
  const std::string name = root.text("name");
  const auto plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '.';
  };
  const bool fine = !name.empty() && name.front() != '.' && std::all_of(name.begin(), name.end(), plain);
  if (!fine) root.problem("name", "it must be made of letters, digits, '-', '_' and '.', and not begin with a '.'.");
  return name;
}

void refuse(json::Reader& root, const std::string& kind, const std::vector<std::string>& keys) {
  for (const std::string& key : keys)
    if (root.has(key))
      root.problem(key, "a workflow of kind " + kind + " has no such section.", "Remove it, or change the kind.");
}

void read_coupled(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  campaign.pbm_case.name = campaign.dem_case.name = campaign.name;
  read_materials(root, campaign, problems);
  read_machine(root, campaign, problems);
  read_pbm(root, campaign, problems);
  read_process(root, campaign, problems);
  read_dem(root, campaign, problems);
  read_coupling(root, campaign, problems);
  root.raw("estimation");  // read when all else is known to be sound
  refuse(root, "coupled", {"tasks", "sweep", "agglomerates"});
}

void check_tasks_fit(const Campaign& campaign, int nodes, int cores_per_node, json::Problems& problems) {
  pilot::check_tasks(campaign.tasks, pilot::stated_machine(nodes, cores_per_node), campaign.file.string(), problems);
}

/// Without stated cores the machine is as large as the largest task asks for: names and dependencies are checked all
/// the same.
int largest_task(const Campaign& campaign) {
  int cores = 1;
  for (const pilot::TaskSpec& task : campaign.tasks) cores = std::max(cores, task.cores());
  return cores;
}

void read_tasks(json::Reader& root, Campaign& campaign) {
  auto items = root.items("tasks");
  if (!root.has("tasks") || (root.raw("tasks")->is_array() && items.empty()))
    root.problem("tasks", "there is no task.",
                 R"(Add for example "tasks": [{"name": "hello", "command": ["echo", "hello"]}].)");
  for (json::Reader& item : items) {
    campaign.tasks.push_back(pilot::read_task(item));
    if (campaign.tasks.back().name.empty()) item.problem("name", "a task needs a name.");
  }
  refuse(root, "tasks",
         {"materials", "machine", "feed", "charge", "process", "spray", "dem", "pbm", "coupling", "cost_model", "sweep",
          "agglomerates", "estimation"});
}

/// One case of a sweep as a document by itself: what its solver needs and no more.
void read_case(json::Reader& root, Campaign& one, Sweep::Solver solver, json::Problems& problems) {
  one.pbm_case.name = one.dem_case.name = one.name;
  read_materials(root, one, problems);
  read_machine(root, one, problems);
  if (solver == Sweep::Solver::dem) {
    read_dem(root, one, problems);
    read_dem_alone(root, one, problems);
    refuse(root, "sweep with the solver dem", {"feed", "charge", "spray", "pbm"});
    if (problems.empty()) check_dem_alone(one, problems);
  } else {
    one.coupling.mode = CouplingSettings::Mode::pbm_only;
    read_pbm(root, one, problems);
    read_process(root, one, problems);
    refuse(root, "sweep with the solver pbm", {"dem", "agglomerates"});
    check_together(one, problems);
  }
  refuse(root, "sweep", {"tasks", "coupling", "estimation"});
}

Result<Campaign> understand_case(const Campaign& sweep, const SweepCase& one, json::Problems& problems) {
  Campaign campaign;
  campaign.file = sweep.file;
  campaign.folder = sweep.folder;
  campaign.resources = sweep.resources;
  campaign.cost_model = sweep.cost_model;
  campaign.name = sweep.name;
  campaign.document = sweep.document;
  for (std::size_t k = 0; k < one.values.size(); ++k)
    if (const std::string& pointer = sweep.sweep.settings[k].pointer;
        !one.values[k].is_null() && !set_value(campaign.document, pointer, one.values[k]))
      problems.add(
          {sweep.file.string(), pointer, "", "the workflow has no such place in a list.", "Sweep the whole list."});
  json::Reader root(campaign.document, sweep.file.string(), problems);
  for (const char* known :
       {"$schema", "granary", "kind", "name", "description", "sweep", "resources", "outputs", "cost_model"})
    root.raw(known);
  read_case(root, campaign, sweep.sweep.solver, problems);
  root.done();
  if (!problems.empty()) return problems.error();
  return campaign;
}

/// A fault that all cases share is told once; one of a swept value at the place where that value stands.
void read_cases(Campaign& campaign, json::Problems& problems) {
  Sweep& sweep = campaign.sweep;
  for (SweepCase& one : sweep.cases) {
    json::Problems own;
    auto understood = understand_case(campaign, one, own);
    if (understood) one.understood = std::make_shared<const Campaign>(std::move(*understood));
    for (json::Problem problem : own.list()) {
      for (std::size_t k = 0; k < sweep.settings.size(); ++k)
        if (const std::string& pointer = sweep.settings[k].pointer;
            !one.places[k].empty() && is_within(problem.pointer, pointer))
          problem.pointer = one.places[k] + problem.pointer.substr(pointer.size());
      problems.add(std::move(problem));
    }
  }
}

/// No setting of ours is null; the reader would take some for left out.
void refuse_nulls(const json::Value& value, const std::string& file, const std::string& pointer,
                  json::Problems& problems) {
  if (value.is_null())
    problems.add({file, pointer, "null", "no setting is null.", "Leave it out, and it takes its default."});
  if (value.is_object())
    for (const auto& [key, member] : value.members()) refuse_nulls(member, file, with_step(pointer, key), problems);
  if (value.is_array())
    for (std::size_t i = 0; i < value.size(); ++i)
      refuse_nulls(value.items()[i], file, with_step(pointer, std::to_string(i)), problems);
}

/// The campaign that a document describes; what is wrong with it goes to the problems.
Result<Campaign> understand(json::Value document, const fs::path& file, const fs::path& folder,
                            json::Problems& problems) {
  Campaign campaign;
  campaign.file = file;
  campaign.folder = folder;
  campaign.document = std::move(document);

  json::Reader root(campaign.document, file.string(), problems);
  if (!campaign.document.is_object()) return problems.error();
  refuse_nulls(campaign.document, file.string(), "", problems);
  root.text_or("$schema", "");
  read_version(root);
  campaign.name = read_name(root);
  campaign.description = root.text_or("description", "");
  const auto kind = read_kind(root);
  if (!kind) return problems.error();  // what else is asked of it depends on the kind
  campaign.kind = *kind;
  read_running(root, campaign, problems);
  if (campaign.kind == Kind::sweep) {
    read_sweep(root, campaign, problems);
    read_cases(campaign, problems);
  } else {
    if (campaign.kind == Kind::coupled)
      read_coupled(root, campaign, problems);
    else
      read_tasks(root, campaign);
    root.done();
  }

  const int cores = campaign.resources.cores.value_or(largest_task(campaign));
  if (campaign.kind == Kind::tasks) check_tasks_fit(campaign, campaign.resources.nodes, cores, problems);
  if (campaign.kind == Kind::coupled) {
    if (problems.empty()) choose_likely_time_step(campaign);
    check_together(campaign, problems);
    read_estimation(root, campaign, problems);
  }
  if (campaign.kind != Kind::tasks && campaign.resources.cores)
    check_cores(campaign, campaign.resources.nodes, cores, problems);
  // The schema is the second net: it knows the same rules (a test holds the two together), but says less about a fault.
  if (problems.empty()) GRANARY_CHECK(validate_workflow(campaign.document, file.string(), problems));
  if (!problems.empty()) return problems.error();
  return campaign;
}

}  // namespace

Result<Campaign> read_campaign(const fs::path& file, const std::vector<std::string>& overrides) {
  GRANARY_TRY(json::Value document, json::read_file(file));
  json::Problems problems;
  if (document.is_object()) apply_overrides(document, overrides, workflow_schema(), problems);
  std::error_code ignored;
  return understand(std::move(document), file, fs::absolute(file, ignored).parent_path(), problems);
}

Status check_resources(const Campaign& campaign, int nodes, int cores_per_node) {
  json::Problems problems;
  if (campaign.kind == Kind::tasks)
    check_tasks_fit(campaign, nodes, cores_per_node, problems);
  else
    check_cores(campaign, nodes, cores_per_node, problems);
  if (!problems.empty()) return problems.error();
  return {};
}

Result<Campaign> reread_campaign(json::Value document, const fs::path& file, const fs::path& folder) {
  json::Problems problems;
  return understand(std::move(document), file, folder, problems);
}

}  // namespace granary::campaign
