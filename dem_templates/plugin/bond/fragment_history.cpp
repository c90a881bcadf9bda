#include "dem_templates/plugin/bond/fragment_history.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace granary::dem {
namespace {

constexpr const char* kModes[] = {"tension", "shear", "bending", "torsion"};

json::Value whole(double number) { return static_cast<std::int64_t>(number); }

}  // namespace

void FragmentHistory::set_causes(std::vector<std::string> names, double window_steps) {
  names_ = std::move(names);
  window_ = window_steps;
}

void FragmentHistory::set_graph(const FragmentSurvey& survey) {
  graph_ = {};
  for (const auto& particle : survey.particles) {
    graph_.add_particle(particle.tag);
    agglomerates_.insert(particle.agglomerate);
  }
  for (const auto& [a, b] : survey.bonds) graph_.add_bond(a, b);
}

void FragmentHistory::start(const FragmentSurvey& survey) { set_graph(survey); }

std::vector<json::Value> FragmentHistory::break_lines(std::vector<BreakEvent> events,
                                                      const std::unordered_map<Tag, Squeeze>& squeezes) {
  std::sort(events.begin(), events.end(), [](const BreakEvent& a, const BreakEvent& b) {
    return std::tie(a.step, a.tag, a.far_tag) < std::tie(b.step, b.tag, b.far_tag);
  });
  std::vector<json::Value> lines;
  for (const BreakEvent& event : events) {
    const std::vector<Tag> fragment = graph_.fragment_of(event.tag);
    graph_.remove_bond(event.tag, event.far_tag);
    ++broken_;
    broken_agglomerates_.insert(event.agglomerate);
    const int cause = cause_of(event, fragment, squeezes);
    causes_since_.emplace_back(event.tag, cause);
    lines.push_back(json::Value::object({{"time_s", event.time},
                                         {"agglomerate", event.agglomerate},
                                         {"tags", json::Array{event.tag, event.far_tag}},
                                         {"position_m", std::vector<double>(event.place.begin(), event.place.end())},
                                         {"mode", kModes[static_cast<std::size_t>(event.mode)]},
                                         {"stress_pa", event.stress},
                                         {"cause", name_of(cause)},
                                         {"fragment_spheres", fragment.size()}}));
  }
  return lines;
}

int FragmentHistory::cause_of(const BreakEvent& event, const std::vector<Tag>& fragment,
                              const std::unordered_map<Tag, Squeeze>& squeezes) {
  int cause = -1;
  double deepest = -1.0;
  for (const Tag tag : fragment) {
    const auto found = squeezes.find(tag);
    if (found == squeezes.end()) continue;
    const Squeeze& s = found->second;
    const int number = static_cast<int>(s.cause);
    if (event.step - s.step > window_ || s.depth <= deepest || number >= static_cast<int>(names_.size())) continue;
    deepest = s.depth;
    cause = number;
  }
  if (deepest > kOwnDebris) {
    for (const Tag tag : fragment) blows_[tag] = {cause, event.step};
    return cause;
  }
  // What was one piece at the blow has it in common, whichever particle is asked.
  const auto blow = blows_.find(event.tag);
  return blow != blows_.end() && event.step - blow->second.step <= window_ ? blow->second.cause : cause;
}

// The one that broke most of its bonds; of equals the first by name.
int FragmentHistory::cause_of(const Split& split) const {
  std::map<std::string, std::pair<int, int>> votes;  // by name: how many, for which
  for (const auto& [tag, cause] : causes_since_)
    if (std::binary_search(split.parent.begin(), split.parent.end(), tag)) {
      auto& [n, number] = votes[name_of(cause)];
      ++n, number = cause;
    }
  const auto most = std::max_element(votes.begin(), votes.end(),
                                     [](const auto& a, const auto& b) { return a.second.first < b.second.first; });
  return most == votes.end() ? -1 : most->second.second;
}

json::Value FragmentHistory::sample_line(double time, double step, const FragmentSurvey& survey) {
  set_graph(survey);
  std::unordered_map<Tag, FragmentParticle> particles;
  std::unordered_map<Tag, Tag> agglomerate;
  for (const auto& particle : survey.particles) {
    particles[particle.tag] = particle.shape;
    agglomerate[particle.tag] = particle.agglomerate;
  }

  const std::vector<std::vector<Tag>> now = graph_.fragments();
  std::vector<std::pair<double, double>> solid, spread;
  std::map<std::size_t, std::int64_t> counts;
  for (const std::vector<Tag>& fragment : now) {
    const FragmentSize size = fragment_size(fragment, graph_, particles, survey.period);
    solid.emplace_back(size.diameter, size.volume);
    spread.emplace_back(size.spread_diameter, size.volume);
    ++counts[fragment.size()];
  }
  json::Array sizes, splits;
  for (const auto& [spheres, count] : counts) sizes.push_back(json::Array{spheres, count});
  for (const Split& split : splits_between(fragments_, now)) {
    json::Array daughters(split.daughters.begin(), split.daughters.end());
    const auto there = std::find_if(split.parent.begin(), split.parent.end(),
                                    [&](Tag tag) { return agglomerate.find(tag) != agglomerate.end(); });
    splits.push_back(json::Value::object({{"parent", split.parent.size()},
                                          {"daughters", std::move(daughters)},
                                          {"cause", name_of(cause_of(split))},
                                          {"agglomerate", agglomerate[*there]}}));
  }

  const double bonds = static_cast<double>(survey.bonds.size());
  const double d50 = weighted_quantile(solid, 0.5), d84 = weighted_quantile(solid, 0.84);
  const double n_agglomerates = static_cast<double>(agglomerates_.size());
  json::Value line = json::Value::object(
      {{"time_s", time},
       {"step", whole(step)},
       {"bonds", survey.bonds.size()},
       {"broken", whole(broken_)},
       {"breakage_ratio", broken_ > 0.0 ? broken_ / (bonds + broken_) : 0.0},
       {"agglomerate_breakage_ratio",
        n_agglomerates > 0.0 ? static_cast<double>(broken_agglomerates_.size()) / n_agglomerates : 0.0},
       {"fragments", now.size()},
       {"d50_m", d50},
       {"d84_m", d84},
       {"sigma", d50 > 0.0 ? d84 / d50 : 0.0},
       {"d50_hull_m", weighted_quantile(spread, 0.5)},
       {"d84_hull_m", weighted_quantile(spread, 0.84)},
       {"sizes", std::move(sizes)},
       {"splits", std::move(splits)}});
  fragments_ = now;
  causes_since_.clear();
  last_sample_ = step;
  return line;
}

// Counts, then each list with its length before it. A fragment is its tags.
std::vector<double> FragmentHistory::state() const {
  std::vector<double> values{broken_, last_sample_};
  const auto list = [&values](const auto& tags) {
    values.push_back(static_cast<double>(tags.size()));
    for (const Tag tag : tags) values.push_back(static_cast<double>(tag));
  };
  list(agglomerates_);
  list(broken_agglomerates_);
  values.push_back(static_cast<double>(fragments_.size()));
  for (const auto& fragment : fragments_) list(fragment);
  values.push_back(static_cast<double>(causes_since_.size()));
  for (const auto& [tag, cause] : causes_since_) {
    values.push_back(static_cast<double>(tag));
    values.push_back(cause);
  }
  values.push_back(static_cast<double>(blows_.size()));
  for (const auto& [tag, blow] : blows_)
    values.insert(values.end(), {static_cast<double>(tag), static_cast<double>(blow.cause), blow.step});
  return values;
}

void FragmentHistory::set_state(const double* values) {
  broken_ = *values++;
  last_sample_ = *values++;
  const auto list = [&values](auto put) {
    for (auto n = static_cast<std::size_t>(*values++); n-- > 0;) put(static_cast<Tag>(*values++));
  };
  list([this](Tag tag) { agglomerates_.insert(tag); });
  list([this](Tag tag) { broken_agglomerates_.insert(tag); });
  fragments_.resize(static_cast<std::size_t>(*values++));
  for (auto& fragment : fragments_) list([&fragment](Tag tag) { fragment.push_back(tag); });
  causes_since_.resize(static_cast<std::size_t>(*values++));
  for (auto& [tag, cause] : causes_since_) {
    tag = static_cast<Tag>(*values++);
    cause = static_cast<int>(*values++);
  }
  for (auto n = static_cast<std::size_t>(*values++); n-- > 0; values += 3)
    blows_[static_cast<Tag>(values[0])] = {static_cast<int>(values[1]), values[2]};
}

}  // namespace granary::dem
