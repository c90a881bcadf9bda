// What is remembered of each particle from one look to the next, so that a contact counts when it begins, once. Follows
// the particles when they are renumbered, deleted, or sent to another rank.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace granary::dem {

constexpr std::size_t kMostBodies = 52;  ///< bits that a double carries exactly

class ContactBook {
 public:
  struct Memory {
    bool known = false;                                       ///< false: it was not there at the last look
    std::array<double, 3> velocity{};                         ///< at the last look [m/s]
    std::uint64_t bodies = 0;                                 ///< bit b: it touched body b at the last look
    double axial = std::numeric_limits<double>::quiet_NaN();  ///< place along the axis when last surveyed [m]
  };
  Memory& memory(std::size_t particle) { return memories_[particle]; }

  // Pairs that touched at the last look, by their tags, are written down only while the caller's own list of pairs is
  // being made anew. They go with the particle of the smaller tag, their owner.
  void note_pair(std::int64_t owner, std::int64_t other);
  bool touched(std::int64_t owner, std::int64_t other) const;
  void forget_pairs();

  void resize(std::size_t n_particles) { memories_.resize(n_particles); }
  void copy(std::size_t from, std::size_t to) { memories_[to] = memories_[from]; }
  void clear(std::size_t particle) { memories_[particle] = {}; }
  std::size_t largest_packed() const;                                                ///< doubles, of any particle
  std::size_t pack(std::size_t particle, std::int64_t tag, double* buffer) const;    ///< returns how many were written
  std::size_t unpack(std::size_t particle, std::int64_t tag, const double* buffer);  ///< returns how many were read

 private:
  using Pair = std::pair<std::int64_t, std::int64_t>;
  /// Where the pair is in the table, or the free place where it belongs.
  std::size_t place(const Pair& pair) const;

  std::vector<Memory> memories_;
  std::vector<Pair> pairs_;
  std::vector<std::uint32_t> table_;  ///< numbers of the pairs, from 1 on, by hash; 0: free; a power of two of them
};

}  // namespace granary::dem
