#include "dem_templates/plugin/bond/bond_graph.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <set>

namespace granary::dem {

void BondGraph::add_bond(Tag a, Tag b) {
  neighbours_[a].push_back(b);
  neighbours_[b].push_back(a);
}

void BondGraph::remove_bond(Tag a, Tag b) {
  const auto drop = [this](Tag from, Tag to) {
    std::vector<Tag>& list = neighbours_[from];
    if (const auto at = std::find(list.begin(), list.end(), to); at != list.end()) list.erase(at);
  };
  drop(a, b);
  drop(b, a);
}

std::vector<Tag> BondGraph::fragment_of(Tag tag) const {
  std::set<Tag> seen{tag};
  std::vector<Tag> found{tag};
  for (std::size_t at = 0; at < found.size(); ++at)
    for (const Tag other : neighbours_.at(found[at]))
      if (seen.insert(other).second) found.push_back(other);
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::vector<Tag>> BondGraph::fragments() const {
  std::set<Tag> seen;
  std::vector<std::vector<Tag>> all;
  for (const auto& [tag, bonded] : neighbours_) {
    if (seen.contains(tag)) continue;
    all.push_back(fragment_of(tag));
    seen.insert(all.back().begin(), all.back().end());
  }
  return all;
}

std::vector<Tag> fragment_labels(const std::vector<std::pair<Tag, Tag>>& bonds) {
  Tag largest = 0;
  for (const auto& [a, b] : bonds) largest = std::max({largest, a, b});
  std::vector<Tag> label(static_cast<std::size_t>(largest) + 1);
  std::iota(label.begin(), label.end(), Tag{0});
  const auto lowest = [&label](Tag tag) {
    while (label[static_cast<std::size_t>(tag)] != tag) {
      Tag& up = label[static_cast<std::size_t>(tag)];
      up = label[static_cast<std::size_t>(up)];  // halves the way for the next one
      tag = up;
    }
    return tag;
  };
  for (const auto& [a, b] : bonds) {
    const Tag x = lowest(a), y = lowest(b);
    label[static_cast<std::size_t>(std::max(x, y))] = std::min(x, y);
  }
  for (Tag tag = 0; tag <= largest; ++tag) label[static_cast<std::size_t>(tag)] = lowest(tag);
  return label;
}

std::vector<Split> splits_between(const std::vector<std::vector<Tag>>& before,
                                  const std::vector<std::vector<Tag>>& now) {
  std::unordered_map<Tag, std::size_t> fragment;
  for (std::size_t f = 0; f < now.size(); ++f)
    for (const Tag tag : now[f]) fragment[tag] = f;

  std::vector<Split> splits;
  for (const std::vector<Tag>& parent : before) {
    std::map<std::size_t, std::size_t> sizes;
    for (const Tag tag : parent)
      if (const auto found = fragment.find(tag); found != fragment.end()) ++sizes[found->second];
    if (sizes.size() < 2) continue;
    Split split{.parent = parent, .daughters = {}};
    for (const auto& [f, size] : sizes) split.daughters.push_back(size);
    std::sort(split.daughters.begin(), split.daughters.end(), std::greater<>());
    splits.push_back(std::move(split));
  }
  return splits;
}

}  // namespace granary::dem
