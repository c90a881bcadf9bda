// What each particle remembers of its touches with bodies from one step to the next. Follows the particles when they
// are renumbered, deleted, written to a restart or sent to another rank.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dem_templates/plugin/wall/contact_law.hpp"
#include "dem_templates/plugin/wall/surface.hpp"

namespace granary::dem {

class TouchBook {
 public:
  static constexpr std::size_t kMost = 6;  ///< touches of one particle that keep their history
  static constexpr std::size_t kMostBodies = 255;
  static constexpr std::uint8_t kNone = kMostBodies;  ///< number of no body

  /// Laid out by what is read together: two touches without rolling resistance lie in the first two lines of memory.
  struct alignas(64) Page {
    struct Place {
      Vector3 normal{};  ///< in the body's frame
      Vector3 shear{};   ///< as in TouchHistory
    };
    std::uint32_t n = 0;
    std::array<std::uint8_t, 8> body{kNone, kNone, kNone, kNone, kNone, kNone, kNone, kNone};  ///< their numbers
    std::array<Place, kMost> place;
    std::array<Vector3, kMost> rolling{};  ///< TouchHistory::rolling_torque of each

    /// The touches of a body are those with these normals now, each on the place of the page that slot tells (kMost:
    /// it is full). Each goes on with the history of the one before it whose normal is nearest to its own, if it is
    /// near enough to be the same touch moved on; a step turns a normal by v dt / R, some hundredths. Returns whether
    /// there was a touch before.
    bool go_on(std::uint8_t of_body, std::span<const SurfaceTouch> now, std::size_t* slot) {
      std::uint32_t old = 0;  // bits: of this body, not taken yet
      for (std::size_t k = 0; k < body.size(); ++k) old |= body[k] == of_body ? 1u << k : 0u;
      if (now.size() == 1 && std::has_single_bit(old)) {  // most
        const auto k = static_cast<std::size_t>(std::countr_zero(old));
        if (dot(place[k].normal, now[0].normal) > kSameTouch) {
          place[k].normal = now[0].normal;
          slot[0] = k;
          return true;
        }
      }
      const bool touched = old != 0;
      for (std::size_t j = 0; j < now.size(); ++j) {
        slot[j] = kMost;
        double likeness = kSameTouch;
        for (std::uint32_t left = old; left != 0; left &= left - 1) {
          const auto k = static_cast<std::size_t>(std::countr_zero(left));
          const double alike = dot(place[k].normal, now[j].normal);
          if (alike <= likeness) continue;
          likeness = alike;
          slot[j] = k;
        }
        if (slot[j] == kMost) continue;
        old &= ~(1u << slot[j]);
        place[slot[j]].normal = now[j].normal;
      }
      for (std::size_t k = n; old != 0 && k-- > 0;) {
        if ((old >> k & 1) == 0) continue;
        move_last_to(k);
        for (std::size_t j = 0; j < now.size(); ++j)
          if (slot[j] == n) slot[j] = k;
      }
      for (std::size_t j = 0; j < now.size() && n < kMost; ++j) {
        if (slot[j] != kMost) continue;
        slot[j] = n;
        body[n] = of_body;
        place[n] = {now[j].normal, {}};
        rolling[n++] = {};
      }
      return touched;
    }
    /// All touches of this body.
    void forget(std::uint8_t of_body) {
      for (std::size_t k = n; k-- > 0;)
        if (body[k] == of_body) move_last_to(k);
    }

   private:
    void move_last_to(std::size_t k) {
      --n;
      body[k] = body[n];
      place[k] = place[n];
      rolling[k] = rolling[n];
      body[n] = kNone;
    }
  };

  /// It will be asked for soon.
  void fetch(std::size_t particle) const {
    __builtin_prefetch(&pages_[particle]);
    __builtin_prefetch(&pages_[particle].place[1]);
  }
  Page& page(std::size_t particle) { return pages_[particle]; }
  const Page& page(std::size_t particle) const { return pages_[particle]; }

  void resize(std::size_t n_particles) { pages_.resize(n_particles); }
  void copy(std::size_t from, std::size_t to) { pages_[to] = pages_[from]; }
  void clear(std::size_t particle) { pages_[particle] = {}; }

  static constexpr std::size_t kDoubles = 10;  ///< of a packed touch
  static constexpr std::size_t kMostPacked = 1 + kMost * kDoubles;
  std::size_t packed_size(std::size_t particle) const { return 1 + pages_[particle].n * kDoubles; }
  /// Returns packed_size().
  std::size_t pack(std::size_t particle, double* buffer) const {
    const Page& from = pages_[particle];
    *buffer++ = from.n;
    for (std::size_t k = 0; k < from.n; ++k) {
      *buffer++ = from.body[k];
      for (const Vector3* vector : {&from.place[k].normal, &from.place[k].shear, &from.rolling[k]})
        buffer = std::copy(vector->begin(), vector->end(), buffer);
    }
    return packed_size(particle);
  }
  /// Returns how many doubles were read.
  std::size_t unpack(std::size_t particle, const double* buffer) {
    Page& to = pages_[particle] = {};
    to.n = static_cast<std::uint32_t>(std::min(*buffer++, static_cast<double>(kMost)));
    for (std::size_t k = 0; k < to.n; ++k) {
      to.body[k] = static_cast<std::uint8_t>(*buffer++);
      for (Vector3* vector : {&to.place[k].normal, &to.place[k].shear, &to.rolling[k]}) {
        std::copy_n(buffer, 3, vector->begin());
        buffer += 3;
      }
    }
    return packed_size(particle);
  }

 private:
  static constexpr double kSameTouch = 0.9;  ///< cosine: 26 degrees

  std::vector<Page> pages_;
};

}  // namespace granary::dem
