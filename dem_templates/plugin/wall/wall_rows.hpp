// Touches of one body, laid out so that the processor works out the forces of several at once.
#pragma once

#include <array>
#include <cstddef>

#include "dem_templates/plugin/wall/contact_law.hpp"

namespace granary::dem {

class WallRows {
 public:
  /// What goes in and comes out stays in the fastest memory.
  static constexpr std::size_t kMost = 64;

  /// How the body stands and turns.
  struct Frame {
    Turn turn;
    Vector3 spin{};  ///< [rad/s]
  };
  struct Touch {
    double radius = 0.0, mass = 0.0;
    double overlap = 0.0;                               ///< > 0 [m]
    Vector3 normal{};                                   ///< from the wall to the centre, in the body's frame
    Vector3 point{};                                    ///< where it is touched, from the body's origin, in its frame
    const double *velocity = nullptr, *spin = nullptr;  ///< of the particle, in the laboratory's frame
  };

  WallRows();
  std::size_t size() const { return size_; }
  bool full() const { return size_ == kMost; }
  void clear() { size_ = 0; }
  /// Not when it is full.
  void add(const WallMaterial& material, const Touch& touch, const TouchHistory& history);

  /// wall_force() of all rows.
  void advance(const Frame& frame, RollingModel rolling, double time_step, bool frozen);

  // Of row k, then. In the laboratory's frame:
  Vector3 force(std::size_t k) const { return vector(kForce, k); }    ///< on the particle [N]
  Vector3 torque(std::size_t k) const { return vector(kTorque, k); }  ///< on it, about its centre [N m]
  // In the body's:
  TouchHistory history(std::size_t k) const { return {vector(kShear, k), vector(kRolling, k)}; }
  double normal_force(std::size_t k) const { return at(kNormalForce, k); }     ///< spring and dashpot [N]
  double normal_speed(std::size_t k) const { return at(kNormalSpeed, k); }     ///< away from the wall [m/s]
  double slip_speed(std::size_t k) const { return std::sqrt(at(kSlip2, k)); }  ///< over the wall's surface [m/s]
  double speed(std::size_t k) const { return std::sqrt(at(kSpeed2, k)); }      ///< of the approach [m/s]

  // Columns; three of a vector.
  static constexpr std::size_t kRadius = 0, kMass = 1, kOverlap = 2, kNormal = 3, kPoint = 6, kVelocity = 9, kSpin = 12,
                               kShear = 15, kRolling = 18, kYoung = 21, kShearModulus = 22, kDamping = 23,
                               kFriction = 24, kRollingFriction = 25, kCohesion = 26;  // in; kShear, kRolling also out
  static constexpr std::size_t kForce = 27, kTorque = 30, kNormalForce = 33, kNormalSpeed = 34, kSlip2 = 35,
                               kSpeed2 = 36, kColumns = 37;

 private:
  double at(std::size_t column, std::size_t k) const { return numbers_[column * kMost + k]; }
  Vector3 vector(std::size_t c, std::size_t k) const { return {at(c, k), at(c + 1, k), at(c + 2, k)}; }
  void set(std::size_t column, const double* values) {
    for (std::size_t d = 0; d < 3; ++d) numbers_[(column + d) * kMost + size_] = values[d];
  }

  std::size_t size_ = 0;
  alignas(64) std::array<double, kColumns * kMost> numbers_;  ///< column after column
};

}  // namespace granary::dem
