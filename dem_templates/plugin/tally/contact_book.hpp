// Remembers, for each particle, what it touched at the last look: so that a contact counts when it begins, once.
// Plain data: who the particles and partners are, and which ranks they live on, is the caller's business.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace granary::dem {

/// A partner: the tag of another particle, or body_partner(b).
using Partner = std::int64_t;
constexpr Partner body_partner(std::size_t body) { return -1 - static_cast<Partner>(body); }

class ContactBook {
 public:
  /// What a particle was like at the last look.
  struct Memory {
    bool known = false;                     ///< false: it was not there
    std::array<double, 3> velocity{};       ///< [m/s]
    double axial = 0.0;                     ///< place along the axis [m]
  };
  struct Touch {
    bool began;     ///< they did not touch at the last look
    double speed;   ///< approach speed noted at the last look, else what the caller gave [m/s]
  };

  /// Opens a look. Everything not seen again by the end of it is forgotten.
  void begin_look() { ++look_; }

  /// `owner` and `partner` touch. Several calls in one look are one contact.
  Touch touches(std::size_t owner, Partner partner, double speed);
  /// They do not touch yet but come closer, with this normal speed [m/s]: what touches() gives back at the next look.
  void approaches(std::size_t owner, Partner partner, double speed);

  Memory& memory(std::size_t particle) { return pages_[particle].memory; }

  // Particles are renumbered, deleted and sent to other ranks.
  std::size_t size() const { return pages_.size(); }
  void resize(std::size_t n_particles) { pages_.resize(n_particles); }
  void copy(std::size_t from, std::size_t to) { pages_[to] = pages_[from]; }
  void clear(std::size_t particle) { pages_[particle] = {}; }
  std::size_t packed_size(std::size_t particle) const;                   ///< doubles
  std::size_t pack(std::size_t particle, double* buffer) const;          ///< returns packed_size()
  std::size_t unpack(std::size_t particle, const double* buffer);        ///< returns how many were read

 private:
  struct Contact {
    Partner partner;
    std::uint64_t look;   ///< when it was last seen
    double speed;         ///< of approach; read only if not touching
    bool touching;
  };
  struct Page {
    std::vector<Contact> contacts;  ///< forgotten ones stay as free places
    Memory memory;
  };
  bool remembered(const Contact& contact) const { return look_ - contact.look <= 1; }
  Contact& note(Page& page, Partner partner);

  std::vector<Page> pages_;
  std::uint64_t look_ = 2;  ///< the same on all ranks
};

}  // namespace granary::dem
