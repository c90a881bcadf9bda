#include "dem_templates/plugin/wall/wall_rows.hpp"

#include <algorithm>

#include "common/every_width.hpp"

namespace granary::dem {
namespace {

using Rows = WallRows;

// Written so that the compiler can take several rows at once.
template <RollingModel rolling, bool frozen>
[[gnu::always_inline]] inline void advance_rows(double* __restrict numbers, std::size_t n, const Rows::Frame& frame,
                                                double time_step) {
  const Turn turn = frame.turn;
  const Vector3 wall_spin = frame.spin, origin = frame.origin;
  for (std::size_t k = 0; k < n; ++k) {
    const auto at = [&](std::size_t column) -> double& { return numbers[column * Rows::kMost + k]; };
    const auto vector = [&](std::size_t c) { return Vector3{at(c), at(c + 1), at(c + 2)}; };
    const auto set = [&](std::size_t c, const Vector3& v) { at(c) = v[0], at(c + 1) = v[1], at(c + 2) = v[2]; };

    const Vector3 point = vector(Rows::kPoint) - origin;
    const ContactMaterial material{.young = at(Rows::kYoung),
                                   .shear = at(Rows::kShearModulus),
                                   .damping = at(Rows::kDamping),
                                   .friction = at(Rows::kFriction),
                                   .rolling_friction = at(Rows::kRollingFriction),
                                   .cohesion = at(Rows::kCohesion)};
    const WallApproach approach{.radius = at(Rows::kRadius),
                                .mass = at(Rows::kMass),
                                .overlap = at(Rows::kOverlap),
                                .normal = vector(Rows::kNormal),
                                .velocity = turn.to_body(vector(Rows::kVelocity)) - cross(wall_spin, point),
                                .spin = turn.to_body(vector(Rows::kSpin)),
                                .wall_spin = wall_spin};
    TouchHistory history{vector(Rows::kShear), vector(Rows::kRolling)};
    const WallForce pushed = wall_force<rolling, frozen>(material, approach, time_step, history);
    set(Rows::kForce, turn.to_lab(pushed.force));
    set(Rows::kTorque, turn.to_lab(pushed.torque));
    const Vector3 centre = point + (approach.radius - approach.overlap) * approach.normal;
    set(Rows::kMoment, cross(centre, pushed.force) + pushed.torque);
    at(Rows::kNormalForce) = pushed.normal_force;
    at(Rows::kNormalSpeed) = pushed.normal_speed;
    at(Rows::kSlip2) = pushed.slip2;
    at(Rows::kSpeed2) = dot(approach.velocity, approach.velocity);
    if constexpr (!frozen) {
      set(Rows::kShear, history.shear);
      set(Rows::kRolling, history.rolling_torque);
    }
  }
}

GRANARY_EVERY_WIDTH void advance_sliding(double* numbers, std::size_t n, const Rows::Frame& frame, double dt) {
  advance_rows<RollingModel::none, false>(numbers, n, frame, dt);
}
GRANARY_EVERY_WIDTH void advance_cdt(double* numbers, std::size_t n, const Rows::Frame& frame, double dt) {
  advance_rows<RollingModel::cdt, false>(numbers, n, frame, dt);
}
GRANARY_EVERY_WIDTH void advance_epsd2(double* numbers, std::size_t n, const Rows::Frame& frame, double dt) {
  advance_rows<RollingModel::epsd2, false>(numbers, n, frame, dt);
}

// Once at the start of a run.
void hold(double* numbers, std::size_t n, const Rows::Frame& frame, RollingModel rolling, double dt) {
  switch (rolling) {
    case RollingModel::none:
      return advance_rows<RollingModel::none, true>(numbers, n, frame, dt);
    case RollingModel::cdt:
      return advance_rows<RollingModel::cdt, true>(numbers, n, frame, dt);
    case RollingModel::epsd2:
      return advance_rows<RollingModel::epsd2, true>(numbers, n, frame, dt);
  }
}

// In eighths, for vectors of every width: the same numbers from all.
constexpr std::size_t kVector = 8;
static_assert(Rows::kMost % kVector == 0);
GRANARY_EVERY_WIDTH double sum(const double* numbers, std::size_t n) {
  double part[kVector] = {};
  for (std::size_t k = 0; k < n; k += kVector)
    for (std::size_t v = 0; v < kVector; ++v) part[v] += numbers[k + v];
  return ((part[0] + part[1]) + (part[2] + part[3])) + ((part[4] + part[5]) + (part[6] + part[7]));
}
GRANARY_EVERY_WIDTH double largest_ratio(const double* over, const double* under, std::size_t n) {
  double part[kVector] = {};
  for (std::size_t k = 0; k < n; k += kVector) {
    for (std::size_t v = 0; v < kVector; ++v) {
      const double ratio = over[k + v] / under[k + v];
      part[v] = ratio > part[v] ? ratio : part[v];
    }
  }
  return *std::max_element(part, part + kVector);
}

}  // namespace

WallRows::WallRows(RollingModel rolling) : rolling_(rolling) {
  numbers_.fill(0.0);
  for (const std::size_t column : {kRadius, kMass}) std::fill_n(numbers_.begin() + column * kMost, kMost, 1.0);
}

void WallRows::set_material(const ContactMaterial& material) {
  material_[size_] = &material;
  const double law[6] = {
      material.young,   material.shear, material.damping, material.friction, material.rolling_friction,
      material.cohesion};
  set(kYoung, law);
  set(kFriction, law + 3);
}

// In whole vectors: rows beyond the last hold old numbers, and touch nothing.
WallRows::Sums WallRows::advance(const Frame& frame, double time_step, bool frozen) {
  const std::size_t n = (size_ + kVector - 1) / kVector * kVector;
  for (const std::size_t column : {kOverlap, kShear, kShear + 1, kShear + 2})
    for (std::size_t k = size_; k < n; ++k) numbers_[column * kMost + k] = 0.0;
  double* numbers = numbers_.data();
  if (frozen)
    hold(numbers, n, frame, rolling_, time_step);
  else if (rolling_ == RollingModel::none)
    advance_sliding(numbers, n, frame, time_step);
  else if (rolling_ == RollingModel::cdt)
    advance_cdt(numbers, n, frame, time_step);
  else
    advance_epsd2(numbers, n, frame, time_step);

  const auto column = [&](std::size_t c) { return numbers + c * kMost; };
  const auto sums = [&](std::size_t c) {
    return Vector3{sum(column(c), n), sum(column(c + 1), n), sum(column(c + 2), n)};
  };
  return {sums(kForce), frame.turn.to_lab(sums(kMoment)), largest_ratio(column(kOverlap), column(kRadius), n)};
}

}  // namespace granary::dem
