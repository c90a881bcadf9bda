#include "pilot/task/spec_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <limits>

#include "common/json/text.hpp"

namespace granary::pilot {
namespace {

constexpr std::array<std::pair<const char*, int>, 8> kSignals{{{"SIGTERM", SIGTERM},
                                                               {"SIGINT", SIGINT},
                                                               {"SIGHUP", SIGHUP},
                                                               {"SIGQUIT", SIGQUIT},
                                                               {"SIGUSR1", SIGUSR1},
                                                               {"SIGUSR2", SIGUSR2},
                                                               {"SIGALRM", SIGALRM},
                                                               {"SIGKILL", SIGKILL}}};

std::vector<std::string> signal_names() {
  std::vector<std::string> names;
  for (const auto& [name, number] : kSignals) names.emplace_back(name);
  return names;
}

bool is_plain_name(const std::string& name) {
  const auto plain = [](unsigned char c) { return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-'; };
  return !name.empty() && name.size() <= 200 && name[0] != '.' && std::all_of(name.begin(), name.end(), plain);
}

int small_integer(json::Reader& reader, const std::string& key, int otherwise, int low) {
  const double largest = std::numeric_limits<int>::max();
  return static_cast<int>(reader.integer_or(key, otherwise, json::Range::between(low, largest)));
}

/// "500 MB", "2 GiB": how everybody writes memory; UDUNITS knows only "byte" and its prefixes.
std::int64_t read_memory(json::Reader& task) {
  constexpr std::array<std::pair<const char*, double>, 9> kUnits{{{"B", 1.0},
                                                                  {"kB", 1e3},
                                                                  {"MB", 1e6},
                                                                  {"GB", 1e9},
                                                                  {"TB", 1e12},
                                                                  {"KiB", 1024.0},
                                                                  {"MiB", 1048576.0},
                                                                  {"GiB", 1073741824.0},
                                                                  {"TiB", 1099511627776.0}}};
  const json::Value* value = task.raw("memory");
  if (value == nullptr) return 0;
  if (value->is_string()) {
    const std::string& text = value->as_string();
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    std::string unit(end);
    unit.erase(0, unit.find_first_not_of(' ') == std::string::npos ? unit.size() : unit.find_first_not_of(' '));
    for (const auto& [name, bytes] : kUnits) {
      const double memory = number * bytes;
      if (end != text.c_str() && unit == name && memory >= 1.0 && memory <= 1e18)
        return static_cast<std::int64_t>(memory + 0.5);
    }
  }
  task.problem("memory", "must be a number above 0 with one of the units B, kB, MB, GB, TB, KiB, MiB, GiB, TiB.",
               "Write \"2 GB\".");
  return 0;
}

void read_env(json::Reader& task, TaskSpec& spec) {
  const json::Value* env = task.raw("env");
  if (env == nullptr) return;
  if (!env->is_object()) return task.problem("env", "must be an object of texts, like {\"KEY\": \"value\"}.");
  for (const auto& [key, value] : env->members()) {
    if (key.empty() || key.find('=') != std::string::npos || !value.is_string()) {
      task.problem("env", fmt::format("member \"{}\": the key must be a name without '=', the value a text.", key));
    } else {
      spec.env.emplace_back(key, value.as_string());
    }
  }
}

void read_stop(json::Reader& task, TaskSpec& spec) {
  auto stop = task.optional_section("stop");
  if (!stop) return;
  if (stop->has("signal")) {
    const std::string chosen = stop->choice("signal", signal_names());
    for (const auto& [name, number] : kSignals) {
      if (chosen == name) spec.stop.signal = number;
    }
  }
  spec.stop.grace = stop->quantity_or("grace", spec.stop.grace, "s", json::Range::positive());
  stop->done();
}

void read_success(json::Reader& task, TaskSpec& spec) {
  const json::Value* codes = task.raw("success");
  if (codes == nullptr) return;
  spec.success.reset();
  bool good = codes->is_array() && !codes->items().empty();
  for (std::size_t k = 0; good && k < codes->items().size(); ++k) {
    const json::Value& code = codes->items()[k];
    good = code.is_number() && code.as_number() >= 0.0 && code.as_number() <= 255.0 &&
           code.as_number() == std::floor(code.as_number());
    if (good) spec.success.set(static_cast<std::size_t>(code.as_number()));
  }
  if (!good) task.problem("success", "must be a list of exit codes from 0 to 255.", "Write [0, 1].");
}

/// A relative path that climbs out of the run directory is a mistake, or worse; an absolute one is meant.
void check_paths(json::Reader& task, const TaskSpec& spec) {
  const auto check = [&](const std::string& key, const std::filesystem::path& path) {
    const std::filesystem::path normal = path.lexically_normal();
    const bool leaves = !path.is_absolute() && normal.begin() != normal.end() && *normal.begin() == "..";
    if (leaves) task.problem(key, "leaves the run directory.", "Give the full path if that is meant.");
    return !leaves;
  };
  if (!check("dir", spec.dir)) return;  // whatever lies in it leaves too
  check("stdout", spec.dir / spec.stdout_file);
  check("stderr", spec.dir / spec.stderr_file);
  for (const std::filesystem::path& file : spec.produces) check("produces", spec.dir / file);
}

std::vector<std::filesystem::path> paths_of(const std::vector<std::string>& texts) {
  return {texts.begin(), texts.end()};
}

}  // namespace

TaskSpec read_task(json::Reader& task) {
  TaskSpec spec;
  spec.name = task.text("name");
  if (!spec.name.empty() && !is_plain_name(spec.name)) {
    task.problem("name", "must be made of letters, digits, '.', '_' and '-' (at most 200) and not start with '.'.",
                 "It names the task's output files.");
  }
  if (!task.has("command")) {
    task.problem("command", "is missing.", "Give the program and its arguments as a list: [\"sleep\", \"5\"].");
  }
  spec.command = task.texts_or("command", {});
  if (task.has("command") && (spec.command.empty() || spec.command[0].empty())) {
    task.problem("command", "must be a list of texts, the program first.",
                 "There is no shell: write [\"sleep\", \"5\"], not \"sleep 5\".");
  }
  read_env(task, spec);
  spec.dir = task.text_or("dir", "");
  spec.ranks = small_integer(task, "ranks", spec.ranks, 1);
  spec.threads = small_integer(task, "threads", spec.threads, 1);
  spec.mpi = task.boolean_or("mpi", spec.mpi);
  spec.light = task.boolean_or("light", spec.light);
  spec.memory_bytes = read_memory(task);
  spec.nodes = small_integer(task, "nodes", spec.nodes, 1);
  spec.placement =
      task.choice_or("placement", "pack", {"pack", "spread"}) == "spread" ? Placement::spread : Placement::pack;
  spec.after = task.texts_or("after", {});
  spec.priority = small_integer(task, "priority", spec.priority, std::numeric_limits<int>::min() + 1);
  spec.fill = task.boolean_or("fill", spec.fill);
  spec.preempt = task.choice_or("preempt", "suspend", {"suspend", "kill"}) == "kill" ? Preempt::kill : Preempt::suspend;
  spec.timeout = task.quantity_or("timeout", spec.timeout, "s", json::Range::positive());
  spec.expected = task.quantity_or("expected", spec.expected, "s", json::Range::positive());
  spec.resumable = task.boolean_or("resumable", spec.resumable);
  read_success(task, spec);
  spec.retries = small_integer(task, "retries", spec.retries, 0);
  read_stop(task, spec);
  spec.produces = paths_of(task.texts_or("produces", {}));
  spec.stdout_file = task.text_or("stdout", "");
  spec.stderr_file = task.text_or("stderr", "");
  check_paths(task, spec);
  if (spec.light && spec.fill) task.problem("light", "and fill exclude each other: a light task occupies no core.");
  if (spec.light && (spec.ranks > 1 || spec.threads > 1)) {
    task.problem("light", "is for one process of one thread: a light task occupies no core.",
                 "Take ranks and threads away.");
  }
  if (spec.nodes > spec.ranks) task.problem("nodes", fmt::format("is more than its {} rank(s).", spec.ranks));
  task.done();
  return spec;
}

namespace {

std::vector<std::string> texts(const std::vector<std::filesystem::path>& paths) { return {paths.begin(), paths.end()}; }

std::vector<std::string> texts_in(const json::Value& value, std::string_view key) {
  std::vector<std::string> list;
  if (const json::Value* items = value.find(key); items != nullptr && items->is_array()) {
    for (const json::Value& item : items->items()) {
      if (item.is_string()) list.push_back(item.as_string());
    }
  }
  return list;
}

bool flag(const json::Value& value, std::string_view key) {
  const json::Value& member = value[key];
  return member.is_bool() && member.as_bool();
}

json::Value codes_in(const ExitCodes& codes) {
  json::Value list = json::Value::array();
  for (std::size_t code = 0; code < codes.size(); ++code) {
    if (codes[code]) list.push(code);
  }
  return list;
}

/// What of a task is not the default, into an object as Value or as text.
template <class Object>
void write(const TaskSpec& spec, Object& out) {
  static const TaskSpec standard;
  out.set("name", spec.name).set("command", spec.command);
  if (!spec.env.empty()) {
    json::Value env = json::Value::object();
    for (const auto& [key, text] : spec.env) env.set(key, text);
    out.set("env", env);
  }
  if (!spec.dir.empty()) out.set("dir", spec.dir.string());
  if (spec.ranks != standard.ranks) out.set("ranks", spec.ranks);
  if (spec.threads != standard.threads) out.set("threads", spec.threads);
  if (spec.mpi) out.set("mpi", true);
  if (spec.light) out.set("light", true);
  if (spec.memory_bytes != 0) out.set("memory_bytes", spec.memory_bytes);
  if (spec.nodes != standard.nodes) out.set("nodes", spec.nodes);
  if (spec.placement == Placement::spread) out.set("placement", "spread");
  if (!spec.after.empty()) out.set("after", spec.after);
  if (spec.priority != standard.priority) out.set("priority", spec.priority);
  if (spec.fill) out.set("fill", true);
  if (spec.preempt == Preempt::kill) out.set("preempt", "kill");
  if (spec.timeout > 0.0) out.set("timeout_s", spec.timeout);
  if (spec.expected > 0.0) out.set("expected_s", spec.expected);
  if (spec.resumable) out.set("resumable", true);
  if (spec.success != standard.success) out.set("success", codes_in(spec.success));
  if (spec.retries != 0) out.set("retries", spec.retries);
  if (spec.stop.signal) out.set("stop_signal", *spec.stop.signal);
  if (spec.stop.grace != standard.stop.grace) out.set("grace_s", spec.stop.grace);
  if (!spec.produces.empty()) out.set("produces", texts(spec.produces));
  if (!spec.stdout_file.empty()) out.set("stdout", spec.stdout_file.string());
  if (!spec.stderr_file.empty()) out.set("stderr", spec.stderr_file.string());
}

}  // namespace

json::Value to_json(const TaskSpec& spec) {
  json::Value value = json::Value::object();
  write(spec, value);
  return value;
}

void append(std::string& text, const TaskSpec& spec) {
  json::TextObject out(text);
  write(spec, out);
}

TaskSpec spec_from_json(const json::Value& value) {
  TaskSpec spec;
  spec.name = value.text_or("name", "");
  spec.command = texts_in(value, "command");
  if (const json::Value* env = value.find("env"); env != nullptr && env->is_object()) {
    for (const auto& [key, text] : env->members()) spec.env.emplace_back(key, text.is_string() ? text.as_string() : "");
  }
  spec.dir = value.text_or("dir", "");
  spec.ranks = static_cast<int>(value.integer_or("ranks", spec.ranks));
  spec.threads = static_cast<int>(value.integer_or("threads", spec.threads));
  spec.mpi = flag(value, "mpi");
  spec.light = flag(value, "light");
  spec.memory_bytes = value.integer_or("memory_bytes", 0);
  spec.nodes = static_cast<int>(value.integer_or("nodes", spec.nodes));
  spec.placement = value.text_or("placement", "") == "spread" ? Placement::spread : Placement::pack;
  spec.after = texts_in(value, "after");
  spec.priority = static_cast<int>(value.integer_or("priority", spec.priority));
  spec.fill = flag(value, "fill");
  spec.preempt = value.text_or("preempt", "") == "kill" ? Preempt::kill : Preempt::suspend;
  spec.timeout = value.number_or("timeout_s", spec.timeout);
  spec.expected = value.number_or("expected_s", spec.expected);
  spec.resumable = flag(value, "resumable");
  if (const json::Value* codes = value.find("success"); codes != nullptr && codes->is_array()) {
    spec.success.reset();
    for (const json::Value& code : codes->items()) {
      if (code.is_integer() && code.as_integer() >= 0 && code.as_integer() < 256)
        spec.success.set(static_cast<std::size_t>(code.as_integer()));
    }
  }
  spec.retries = static_cast<int>(value.integer_or("retries", spec.retries));
  if (value.find("stop_signal") != nullptr)
    spec.stop.signal = static_cast<int>(value.integer_or("stop_signal", SIGTERM));
  spec.stop.grace = value.number_or("grace_s", spec.stop.grace);
  spec.produces = paths_of(texts_in(value, "produces"));
  spec.stdout_file = value.text_or("stdout", "");
  spec.stderr_file = value.text_or("stderr", "");
  return spec;
}

}  // namespace granary::pilot
