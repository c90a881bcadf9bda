#include "dem_templates/plugin/pair/pair_rows.hpp"

#include <algorithm>

#include "common/every_width.hpp"

namespace granary::dem {
namespace {

using Rows = PairRows;

// Written so that the compiler can take several rows at once.
template <bool rolling>
[[gnu::always_inline]] inline void advance_rows(double* __restrict numbers, std::size_t n, double time_step) {
  for (std::size_t k = 0; k < n; ++k) {
    const auto at = [&](std::size_t column) -> double& { return numbers[column * Rows::kMost + k]; };
    const auto vector = [&](std::size_t c) { return Vector3{at(c), at(c + 1), at(c + 2)}; };
    const auto set = [&](std::size_t c, const Vector3& v) { at(c) = v[0], at(c + 1) = v[1], at(c + 2) = v[2]; };

    const double radius_i = at(Rows::kAlone), radius_j = at(Rows::kAlone + 1);
    const double mass_i = at(Rows::kAlone + 2), mass_j = at(Rows::kAlone + 3);
    const Vector3 between = vector(Rows::kDistance), velocity = vector(Rows::kVelocity);
    const double distance = norm(between), overlap = radius_i + radius_j - distance;
    const Vector3 normal = (1.0 / distance) * between;
    const double arm_i = radius_i - 0.5 * overlap, arm_j = radius_j - 0.5 * overlap;
    const double normal_speed = dot(velocity, normal);
    const Vector3 spin_i = vector(Rows::kSpinI), spin_j = vector(Rows::kSpinJ);
    const ContactMaterial material{at(Rows::kYoung), at(Rows::kShearModulus), at(Rows::kDamping), at(Rows::kFriction)};
    const ContactState contact{
        .radius = radius_i * radius_j / (radius_i + radius_j),
        .mass = mass_i * mass_j / (mass_i + mass_j),
        .overlap = overlap,
        .normal = normal,
        .normal_speed = normal_speed,
        .slip = velocity - normal_speed * normal + cross(normal, arm_i * spin_i + arm_j * spin_j)};
    Vector3 shear = vector(Rows::kShear);
    const ContactForce pushed = contact_force<false>(material, contact, time_step, shear);
    set(Rows::kForce, pushed.normal * normal + pushed.tangential);
    const Vector3 twist = cross(normal, pushed.tangential);
    Vector3 torque_i = -arm_i * twist, torque_j = -arm_j * twist;
    if constexpr (rolling) {
      Vector3 history = vector(Rows::kRolling);
      const Vector3 resisting =
          rolling_torque<false>(at(Rows::kRollingFriction), contact, pushed, spin_i - spin_j, time_step, history);
      torque_i = torque_i - resisting;
      torque_j = torque_j + resisting;
      set(Rows::kRolling, history);
    }
    set(Rows::kTorqueI, torque_i);
    set(Rows::kTorqueJ, torque_j);
    set(Rows::kShear, shear);
    at(Rows::kOverlap) = overlap / (radius_i < radius_j ? radius_i : radius_j);
  }
}

GRANARY_EVERY_WIDTH void advance_sliding(double* numbers, std::size_t n, double time_step) {
  advance_rows<false>(numbers, n, time_step);
}
GRANARY_EVERY_WIDTH void advance_rolling(double* numbers, std::size_t n, double time_step) {
  advance_rows<true>(numbers, n, time_step);
}

constexpr std::size_t kVector = 8;
static_assert(Rows::kMost % kVector == 0);

}  // namespace

// Rows that were never filled hold two spheres apart.
PairRows::PairRows(bool rolling) : rolling_(rolling) {
  numbers_.fill(0.0);
  std::fill_n(numbers_.begin() + kAlone * kMost, 4 * kMost, 1.0);
  std::fill_n(numbers_.begin() + kDistance * kMost, kMost, 2.0);
}

void PairRows::set_material(const ContactMaterial& material) {
  material_[size_] = &material;
  at(kYoung, size_) = material.young;
  at(kShearModulus, size_) = material.shear;
  at(kDamping, size_) = material.damping;
  at(kFriction, size_) = material.friction;
  at(kRollingFriction, size_) = material.rolling_friction;
}

// In whole vectors: rows beyond the last hold old numbers, and touch nothing.
double PairRows::advance(double time_step) {
  const std::size_t n = (size_ + kVector - 1) / kVector * kVector;
  for (std::size_t d = 0; d < 3; ++d)
    for (std::size_t k = size_; k < n; ++k) at(kShear + d, k) = 0.0;
  (rolling_ ? advance_rolling : advance_sliding)(numbers_.data(), n, time_step);
  const double* const overlaps = numbers_.data() + kOverlap * kMost;
  return size_ > 0 ? *std::max_element(overlaps, overlaps + size_) : 0.0;
}

}  // namespace granary::dem
