// What each particle keeps about its bonds: those to partners with larger tags, the agglomerate it belongs to, and what
// squeezed it last. Follows the particles when they are renumbered, deleted, written to a restart or sent to another
// rank.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

#include "dem_templates/plugin/bond/bond_law.hpp"

namespace granary::dem {

/// Weight of the depths between pieces of one agglomerate: below all others.
constexpr double kOwnDebris = 1e-9;

/// What leant on a particle, when, and how far in.
struct Squeeze {
  double cause = -1.0;  ///< number of the cause; -1: nothing yet
  double depth = 0.0;   ///< by which the particle itself gave in, over its radius
  double step = 0.0;

  /// The deepest of the last `window` steps stays.
  void note(double now, double by, double how_deep, double window) {
    if (cause >= 0.0 && now - step <= window && how_deep < depth) return;
    *this = {by, how_deep, now};
  }
};

struct BondPage {
  double agglomerate = 0.0;  ///< 0: of none
  double waiting = 0.0;      ///< 1: its bonds are still to be made
  Squeeze squeeze;
  std::vector<Bond> bonds;
};

class BondBook {
 public:
  BondPage& page(std::size_t particle) { return pages_[particle]; }
  const BondPage& page(std::size_t particle) const { return pages_[particle]; }

  void resize(std::size_t n_particles) { pages_.resize(n_particles); }
  void copy(std::size_t from, std::size_t to) { pages_[to] = pages_[from]; }
  void clear(std::size_t particle) { pages_[particle] = {}; }

  /// Of the bonds that have not broken.
  std::size_t packed_size(std::size_t particle) const {
    const std::vector<Bond>& bonds = pages_[particle].bonds;
    return kHead + kDoubles * (bonds.size() - count_broken(bonds));
  }
  static constexpr std::size_t kLeastPacked = 6;
  /// Returns packed_size().
  std::size_t pack(std::size_t particle, double* buffer) const {
    const BondPage& from = pages_[particle];
    const auto n_bonds = static_cast<double>(from.bonds.size() - count_broken(from.bonds));
    const double head[kHead] = {
        n_bonds, from.agglomerate, from.waiting, from.squeeze.cause, from.squeeze.depth, from.squeeze.step};
    std::copy_n(head, kHead, buffer);
    double* to = buffer + kHead;
    for (const Bond& bond : from.bonds) {
      if (bond.broken()) continue;
      std::memcpy(to, &bond, sizeof bond);
      to += kDoubles;
    }
    return packed_size(particle);
  }
  /// Returns how many doubles were read.
  std::size_t unpack(std::size_t particle, const double* buffer) {
    BondPage& to = pages_[particle];
    to = {buffer[1], buffer[2], {buffer[3], buffer[4], buffer[5]}, {}};
    to.bonds.resize(static_cast<std::size_t>(buffer[0]));
    if (!to.bonds.empty())
      std::memcpy(static_cast<void*>(to.bonds.data()), buffer + kHead, to.bonds.size() * sizeof(Bond));
    return packed_size(particle);
  }

 private:
  static constexpr std::size_t kHead = kLeastPacked, kDoubles = 14;
  static_assert(sizeof(Bond) == kDoubles * sizeof(double));

  static std::size_t count_broken(const std::vector<Bond>& bonds) {
    return static_cast<std::size_t>(
        std::count_if(bonds.begin(), bonds.end(), [](const Bond& b) { return b.broken(); }));
  }

  std::vector<BondPage> pages_;
};

}  // namespace granary::dem
