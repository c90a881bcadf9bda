// Spheres that touch each other, worked out several at once: contact_force() of each pair. Plain numbers: no LIGGGHTS.
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

  PairRows();
  std::size_t size() const { return size_; }
  bool full() const { return size_ == kMost; }
  void clear() { size_ = 0; }
  /// Two that overlap, not when it is full. The material must stay where it is, as it is. shear: as in
  /// contact_force(), of i.
  void add(const ContactMaterial& material, const Sphere& i, const Sphere& j, const double* shear) {
    const double alone[4] = {i.radius, j.radius, i.mass, j.mass};
    for (std::size_t n = 0; n < 4; ++n) at(kAlone + n, size_) = alone[n];
    for (std::size_t d = 0; d < 3; ++d) {
      at(kDistance + d, size_) = i.place[d] - j.place[d];
      at(kVelocity + d, size_) = i.velocity[d] - j.velocity[d];
      at(kSpinI + d, size_) = i.spin[d];
      at(kSpinJ + d, size_) = j.spin[d];
      at(kShear + d, size_) = shear[d];
    }
    if (material_[size_] != &material) set_material(material);
    ++size_;
  }

  /// All rows. Returns the largest overlap over the smaller radius.
  double advance(double time_step);

  // Of row k, then:
  Vector3 force(std::size_t k) const { return vector(kForce, k); }    ///< on i; the opposite on j [N]
  Vector3 torque(std::size_t k) const { return vector(kTorque, k); }  ///< on i about its centre, over its arm [N]
  double arm_i(std::size_t k) const { return at(kArmI, k); }          ///< from its centre to where the two touch [m]
  double arm_j(std::size_t k) const { return at(kArmJ, k); }
  Vector3 shear(std::size_t k) const { return vector(kShear, k); }  ///< advanced

  // Columns; three of a vector.
  static constexpr std::size_t kAlone = 0, kDistance = 4, kVelocity = 7, kSpinI = 10, kSpinJ = 13, kShear = 16,
                               kYoung = 19, kShearModulus = 20, kDamping = 21, kFriction = 22;  // in; kShear also out
  static constexpr std::size_t kForce = 23, kTorque = 26, kArmI = 29, kArmJ = 30, kOverlap = 31, kColumns = 32;

 private:
  double& at(std::size_t column, std::size_t k) { return numbers_[column * kMost + k]; }
  double at(std::size_t column, std::size_t k) const { return numbers_[column * kMost + k]; }
  Vector3 vector(std::size_t c, std::size_t k) const { return {at(c, k), at(c + 1, k), at(c + 2, k)}; }
  void set_material(const ContactMaterial& material);

  std::size_t size_ = 0;
  std::array<const ContactMaterial*, kMost> material_{};      ///< whose numbers the row holds
  alignas(64) std::array<double, kColumns * kMost> numbers_;  ///< column after column
};

}  // namespace granary::dem
