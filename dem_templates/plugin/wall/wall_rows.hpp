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
    Vector3 spin{};    ///< [rad/s]
    Vector3 origin{};  ///< a point of its axis [m]
  };
  struct Touch {
    double radius = 0.0, mass = 0.0;
    double overlap = 0.0;                  ///< > 0 [m]
    const double *normal, *point;          ///< from the wall to the centre; where it is touched: in the body's frame
    const double *velocity, *spin;         ///< of the particle, in the laboratory's frame
    const double *shear, *rolling_torque;  ///< as in TouchHistory
  };
  /// Of all rows.
  struct Sums {
    Vector3 force{}, moment{};  ///< on the particles, about the origin, in the laboratory's frame [N], [N m]
    double deepest = 0.0;       ///< largest overlap over its radius
  };

  explicit WallRows(RollingModel rolling = RollingModel::none);
  std::size_t size() const { return size_; }
  bool full() const { return size_ == kMost; }
  void clear() { size_ = 0; }
  /// Not when it is full. The material must stay where it is, as it is.
  void add(const ContactMaterial& material, const Touch& touch) {
    const double alone[3] = {touch.radius, touch.mass, touch.overlap};
    set(kRadius, alone);
    set(kNormal, touch.normal);
    set(kPoint, touch.point);
    set(kVelocity, touch.velocity);
    set(kSpin, touch.spin);
    set(kShear, touch.shear);
    if (rolling_ == RollingModel::epsd2) set(kRolling, touch.rolling_torque);
    if (material_[size_] != &material) set_material(material);
    ++size_;
  }

  /// wall_force() of all rows.
  Sums advance(const Frame& frame, double time_step, bool frozen);

  // Of row k, then. In the laboratory's frame:
  Vector3 force(std::size_t k) const { return vector(kForce, k); }    ///< on the particle [N]
  Vector3 torque(std::size_t k) const { return vector(kTorque, k); }  ///< on it, about its centre [N m]
  // In the body's:
  Vector3 shear(std::size_t k) const { return vector(kShear, k); }  ///< TouchHistory, advanced
  Vector3 rolling_torque(std::size_t k) const { return vector(kRolling, k); }
  double normal_force(std::size_t k) const { return at(kNormalForce, k); }     ///< spring and dashpot [N]
  double normal_speed(std::size_t k) const { return at(kNormalSpeed, k); }     ///< away from the wall [m/s]
  double slip_speed(std::size_t k) const { return std::sqrt(at(kSlip2, k)); }  ///< over the wall's surface [m/s]
  double speed(std::size_t k) const { return std::sqrt(at(kSpeed2, k)); }      ///< of the approach [m/s]

  // Columns; three of a vector.
  static constexpr std::size_t kRadius = 0, kMass = 1, kOverlap = 2, kNormal = 3, kPoint = 6, kVelocity = 9, kSpin = 12,
                               kShear = 15, kRolling = 18, kYoung = 21, kShearModulus = 22, kDamping = 23,
                               kFriction = 24, kRollingFriction = 25, kCohesion = 26;  // in; kShear, kRolling also out
  static constexpr std::size_t kForce = 27, kTorque = 30, kNormalForce = 33, kNormalSpeed = 34, kSlip2 = 35,
                               kSpeed2 = 36, kMoment = 37, kColumns = 40;

 private:
  double at(std::size_t column, std::size_t k) const { return numbers_[column * kMost + k]; }
  Vector3 vector(std::size_t c, std::size_t k) const { return {at(c, k), at(c + 1, k), at(c + 2, k)}; }
  void set(std::size_t column, const double* values) {
    for (std::size_t d = 0; d < 3; ++d) numbers_[(column + d) * kMost + size_] = values[d];
  }

  void set_material(const ContactMaterial& material);

  RollingModel rolling_;
  std::size_t size_ = 0;
  std::array<const ContactMaterial*, kMost> material_{};      ///< whose numbers the row holds
  alignas(64) std::array<double, kColumns * kMost> numbers_;  ///< column after column
};

}  // namespace granary::dem
