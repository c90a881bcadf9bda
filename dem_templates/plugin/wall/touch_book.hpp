// What each particle remembers of its touches with bodies from one step to the next. Follows the particles when they
// are renumbered, deleted, written to a restart or sent to another rank.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dem_templates/plugin/wall/contact_law.hpp"

namespace granary::dem {

/// In the body's frame.
struct RememberedTouch {
  double body = 0.0;  ///< number of the body
  Vector3 normal{};
  TouchHistory history;
};

class TouchBook {
 public:
  static constexpr std::size_t kMost = 6;  ///< touches of one particle that keep their history
  static constexpr std::size_t kMostPacked = 1 + kMost * sizeof(RememberedTouch) / sizeof(double);

  struct Page {
    std::size_t n = 0;
    std::array<RememberedTouch, kMost> touch;

    bool touched(double body) const {
      return std::any_of(touch.begin(), touch.begin() + static_cast<std::ptrdiff_t>(n),
                         [&](const RememberedTouch& t) { return t.body == body; });
    }
    /// The touch of this body whose normal is nearest to this one, if it is near enough to be the same touch moved on,
    /// and is not one of `kept`; else n. A step turns a normal by v dt / R, some hundredths.
    std::size_t find(double body, const Vector3& normal, const std::array<bool, kMost>& kept) const {
      std::size_t best = n;
      double likeness = kSameTouch;
      for (std::size_t k = 0; k < n; ++k) {
        if (touch[k].body != body || kept[k]) continue;
        const double alike = dot(touch[k].normal, normal);
        if (alike <= likeness) continue;
        likeness = alike;
        best = k;
      }
      return best;
    }
    /// All touches of this body but `kept`.
    void forget_but(double body, const std::array<bool, kMost>& kept) {
      for (std::size_t k = n; k-- > 0;)
        if (touch[k].body == body && !kept[k]) touch[k] = touch[--n];
    }
    /// All touches of this body.
    void forget(double body) {
      for (std::size_t k = n; k-- > 0;)
        if (touch[k].body == body) touch[k] = touch[--n];
    }
    /// False if the page is full.
    bool note(const RememberedTouch& now) {
      if (n == kMost) return false;
      touch[n++] = now;
      return true;
    }
  };

  /// It will be asked for soon.
  void fetch(std::size_t particle) const { __builtin_prefetch(&pages_[particle]); }
  Page& page(std::size_t particle) { return pages_[particle]; }
  const Page& page(std::size_t particle) const { return pages_[particle]; }

  void resize(std::size_t n_particles) { pages_.resize(n_particles); }
  void copy(std::size_t from, std::size_t to) { pages_[to] = pages_[from]; }
  void clear(std::size_t particle) { pages_[particle].n = 0; }

  std::size_t packed_size(std::size_t particle) const { return 1 + pages_[particle].n * kDoubles; }
  /// Returns packed_size().
  std::size_t pack(std::size_t particle, double* buffer) const {
    const Page& from = pages_[particle];
    buffer[0] = static_cast<double>(from.n);
    for (std::size_t k = 0; k < from.n; ++k) {
      const auto& [body, normal, history] = from.touch[k];
      double* to = buffer + 1 + k * kDoubles;
      to[0] = body;
      std::copy(normal.begin(), normal.end(), to + 1);
      std::copy(history.shear.begin(), history.shear.end(), to + 4);
      std::copy(history.rolling_torque.begin(), history.rolling_torque.end(), to + 7);
    }
    return packed_size(particle);
  }
  /// Returns how many doubles were read.
  std::size_t unpack(std::size_t particle, const double* buffer) {
    Page& to = pages_[particle];
    to.n = std::min(static_cast<std::size_t>(buffer[0]), kMost);
    for (std::size_t k = 0; k < to.n; ++k) {
      auto& [body, normal, history] = to.touch[k];
      const double* from = buffer + 1 + k * kDoubles;
      body = from[0];
      std::copy(from + 1, from + 4, normal.begin());
      std::copy(from + 4, from + 7, history.shear.begin());
      std::copy(from + 7, from + 10, history.rolling_torque.begin());
    }
    return packed_size(particle);
  }

 private:
  static constexpr std::size_t kDoubles = 10;
  static constexpr double kSameTouch = 0.9;  ///< cosine: 26 degrees
  static_assert(sizeof(RememberedTouch) == kDoubles * sizeof(double));

  std::vector<Page> pages_;
};

}  // namespace granary::dem
