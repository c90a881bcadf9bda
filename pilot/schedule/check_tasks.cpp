#include "pilot/schedule/check_tasks.hpp"

#include <fmt/format.h>

#include <map>
#include <vector>

namespace granary::pilot {

Status check_fits(const TaskSpec& spec, const Layouts& layouts) {
  if (spec.cores() == 0) return {};
  const Layout layout = layouts.of(spec);
  if (layout.nodes == 0) {
    const std::string need = fmt::format("needs {} core(s) ({} rank(s) x {} thread(s){})", spec.cores(), spec.ranks,
                                         spec.threads, spec.nodes > 0 ? fmt::format(" on {} node(s)", spec.nodes) : "");
    return Error{fmt::format("{}, but there are {} on {} node(s), the largest with {}", need, layouts.n_cores(),
                             layouts.n_nodes(), layouts.largest_node())};
  }
  const std::int64_t share = layout.memory * layout.large;
  if (share > layouts.largest_memory() && layouts.largest_memory() > 0) {
    return Error{fmt::format("needs {:.3g} GB on a node, but the largest has {:.3g} GB",
                             static_cast<double>(share) * 1e-9, static_cast<double>(layouts.largest_memory()) * 1e-9)};
  }
  return {};
}

namespace {

class Checker {
 public:
  Checker(std::span<const TaskSpec> tasks, const std::string& file, json::Problems& problems,
          const std::string& pointer)
      : tasks_(tasks), file_(file), problems_(problems), pointer_(pointer) {}

  void names() {
    for (std::size_t k = 0; k < tasks_.size(); ++k) {
      const std::string& name = tasks_[k].name;
      if (name.empty()) continue;
      const auto [first, is_new] = index_.emplace(name, k);
      if (is_new) continue;
      add(k, "name", name, fmt::format("is the name of task {} already; each task has its own name.", first->second));
    }
  }

  void dependencies() {
    std::vector<std::string> known;
    for (const auto& [name, k] : index_) known.push_back(name);
    for (std::size_t k = 0; k < tasks_.size(); ++k) {
      for (std::size_t a = 0; a < tasks_[k].after.size(); ++a) {
        const std::string& before = tasks_[k].after[a];
        if (index_.count(before) != 0) continue;
        const std::string near = json::did_you_mean(before, known);
        add(k, fmt::format("after/{}", a), before, "is no task of this list.",
            near.empty() ? "" : fmt::format("Did you mean \"{}\"?", near));
      }
    }
  }

  /// Each circle is told once, at the first of its tasks in the document.
  void cycles() {
    enum class Mark { unseen, on_path, done };
    std::vector<Mark> mark(tasks_.size(), Mark::unseen);
    struct Visit {
      std::size_t task, next_dependency;
    };
    for (std::size_t start = 0; start < tasks_.size(); ++start) {
      if (mark[start] != Mark::unseen) continue;
      std::vector<Visit> path{{start, 0}};
      mark[start] = Mark::on_path;
      while (!path.empty()) {
        Visit& visit = path.back();
        const auto& after = tasks_[visit.task].after;
        if (visit.next_dependency == after.size()) {
          mark[visit.task] = Mark::done;
          path.pop_back();
          continue;
        }
        const auto found = index_.find(after[visit.next_dependency++]);
        if (found == index_.end()) continue;
        const std::size_t before = found->second;
        if (mark[before] == Mark::unseen) {
          mark[before] = Mark::on_path;
          path.push_back({before, 0});
        } else if (mark[before] == Mark::on_path) {
          std::string circle;
          std::size_t first = before;
          bool in_circle = false;
          for (const Visit& step : path) {
            in_circle = in_circle || step.task == before;
            if (!in_circle) continue;
            circle += tasks_[step.task].name + " after ";
            first = std::min(first, step.task);
          }
          add(first, "after", "", fmt::format("goes in a circle: {}{}.", circle, tasks_[before].name),
              "No task of the circle could ever start; take one of these dependencies away.");
        }
      }
    }
  }

  void sizes(const Machine& machine) {
    const Layouts layouts(machine);
    for (std::size_t k = 0; k < tasks_.size(); ++k) {
      const Status fits = check_fits(tasks_[k], layouts);
      if (fits) continue;
      const bool too_many_ranks = tasks_[k].ranks >= tasks_[k].threads;
      const int count = too_many_ranks ? tasks_[k].ranks : tasks_[k].threads;
      add(k, too_many_ranks ? "ranks" : "threads", std::to_string(count),
          fmt::format("this task {}.", fits.error().message), "Lower ranks or threads, or give more cores (--cores).");
    }
  }

 private:
  void add(std::size_t task, const std::string& key, const std::string& value, std::string message,
           std::string hint = "") {
    problems_.add({file_, fmt::format("{}/{}/{}", pointer_, task, key), value, std::move(message), std::move(hint)});
  }

  std::span<const TaskSpec> tasks_;
  const std::string& file_;
  json::Problems& problems_;
  const std::string& pointer_;
  std::map<std::string, std::size_t> index_;
};

}  // namespace

void check_tasks(std::span<const TaskSpec> tasks, const Machine& machine, const std::string& file,
                 json::Problems& problems, const std::string& pointer) {
  Checker checker(tasks, file, problems, pointer);
  checker.names();
  checker.dependencies();
  checker.cycles();
  checker.sizes(machine);
}

}  // namespace granary::pilot
