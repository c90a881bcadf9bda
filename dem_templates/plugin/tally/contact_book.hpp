// What is remembered of each particle from one look to the next, so that a contact counts when it begins, once. Follows
// the particles when they are renumbered, deleted, or sent to another rank.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
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
  Memory& memory(std::size_t particle) { return pages_[particle].memory; }

  // Partners are written down only while the caller's own list of pairs is being made anew.
  void note_partner(std::size_t particle, std::int64_t partner) { pages_[particle].partners.push_back(partner); }
  bool had_partner(std::size_t particle, std::int64_t partner) const;
  void forget_partners();

  std::size_t size() const { return pages_.size(); }
  void resize(std::size_t n_particles) { pages_.resize(n_particles); }
  void copy(std::size_t from, std::size_t to) { pages_[to] = pages_[from]; }
  void clear(std::size_t particle) { pages_[particle] = {}; }
  std::size_t packed_size(std::size_t particle) const;             ///< doubles
  std::size_t pack(std::size_t particle, double* buffer) const;    ///< returns packed_size()
  std::size_t unpack(std::size_t particle, const double* buffer);  ///< returns how many were read

 private:
  struct Page {
    Memory memory;
    std::vector<std::int64_t> partners;  ///< particles with larger tags that it touched at the last look
  };
  std::vector<Page> pages_;
};

}  // namespace granary::dem
