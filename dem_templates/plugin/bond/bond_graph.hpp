// Which particles hang together: the graph of the bonds, and the fragments it falls into. Knows no LIGGGHTS.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

namespace granary::dem {

using Tag = std::int64_t;

class BondGraph {
 public:
  void add_particle(Tag tag) { neighbours_.try_emplace(tag); }
  void add_bond(Tag a, Tag b);
  void remove_bond(Tag a, Tag b);
  /// All particles that hang together with this one, sorted; itself too.
  std::vector<Tag> fragment_of(Tag tag) const;
  /// All of them, each sorted, by their lowest tags.
  std::vector<std::vector<Tag>> fragments() const;
  const std::vector<Tag>& bonded_to(Tag tag) const { return neighbours_.at(tag); }

 private:
  std::map<Tag, std::vector<Tag>> neighbours_;
};

/// The lowest tag of the fragment of each tag up to the largest that is bonded; its own for a particle alone. By
/// union-find: fast enough to be done often.
std::vector<Tag> fragment_labels(const std::vector<std::pair<Tag, Tag>>& bonds);

/// What became of a fragment of an earlier time.
struct Split {
  std::vector<Tag> parent;             ///< its particles then
  std::vector<std::size_t> daughters;  ///< numbers of particles, largest first
};

/// Of each earlier fragment that is now more than one. Particles that are gone count nowhere.
std::vector<Split> splits_between(const std::vector<std::vector<Tag>>& before,
                                  const std::vector<std::vector<Tag>>& now);

}  // namespace granary::dem
