// Spheres that touch each other, worked out several at once: contact_force() of each pair, and rolling_torque(). Plain
// numbers: no LIGGGHTS.
#pragma once

#include <array>
#include <cstddef>

#include "dem_templates/plugin/contact_force.hpp"

namespace granary::dem {

class PairRows {
 public:
  static constexpr std::size_t kMost = 64;
  struct Sphere {
    const double *place, *velocity, *spin;  ///< three each [m], [m/s], [rad/s]
    double radius, mass;                    ///< [m], [kg]
  };

  explicit PairRows(bool rolling = false);
  bool rolling() const { return rolling_; }
  std::size_t size() const { return size_; }
  bool full() const { return size_ == kMost; }
  void clear() { size_ = 0; }
  /// Two that overlap, not when it is full. The material must stay where it is, as it is. history: shear as in
  /// contact_force(), and if they resist rolling the torque of rolling_torque(), of i.
  void add(const ContactMaterial& material, const Sphere& i, const Sphere& j, const double* history) {
    const double alone[4] = {i.radius, j.radius, i.mass, j.mass};
    for (std::size_t n = 0; n < 4; ++n) at(kAlone + n, size_) = alone[n];
    for (std::size_t d = 0; d < 3; ++d) {
      at(kDistance + d, size_) = i.place[d] - j.place[d];
      at(kVelocity + d, size_) = i.velocity[d] - j.velocity[d];
      at(kSpinI + d, size_) = i.spin[d];
      at(kSpinJ + d, size_) = j.spin[d];
      at(kShear + d, size_) = history[d];
      if (rolling_) at(kRolling + d, size_) = history[3 + d];
    }
    if (material_[size_] != &material) set_material(material);
    ++size_;
  }

  /// All rows. Returns the largest overlap over the smaller radius.
  double advance(double time_step);

  // Of row k, then:
  Vector3 force(std::size_t k) const { return vector(kForce, k); }       ///< on i; the opposite on j [N]
  Vector3 torque_i(std::size_t k) const { return vector(kTorqueI, k); }  ///< about its centre [N m]
  Vector3 torque_j(std::size_t k) const { return vector(kTorqueJ, k); }
  /// What add() takes, advanced.
  void write_history(std::size_t k, double* history) const {
    for (std::size_t d = 0; d < 3; ++d) {
      history[d] = at(kShear + d, k);
      if (rolling_) history[3 + d] = at(kRolling + d, k);
    }
  }

  // Columns; three of a vector.
  static constexpr std::size_t kAlone = 0, kDistance = 4, kVelocity = 7, kSpinI = 10, kSpinJ = 13, kShear = 16,
                               kRolling = 19, kYoung = 22, kShearModulus = 23, kDamping = 24, kFriction = 25,
                               kRollingFriction = 26;  // in; kShear, kRolling also out
  static constexpr std::size_t kForce = 27, kTorqueI = 30, kTorqueJ = 33, kOverlap = 36, kColumns = 37;

 private:
  double& at(std::size_t column, std::size_t k) { return numbers_[column * kMost + k]; }
  double at(std::size_t column, std::size_t k) const { return numbers_[column * kMost + k]; }
  Vector3 vector(std::size_t c, std::size_t k) const { return {at(c, k), at(c + 1, k), at(c + 2, k)}; }
  void set_material(const ContactMaterial& material);

  bool rolling_;
  std::size_t size_ = 0;
  std::array<const ContactMaterial*, kMost> material_{};      ///< whose numbers the row holds
  alignas(64) std::array<double, kColumns * kMost> numbers_;  ///< column after column
};

}  // namespace granary::dem
