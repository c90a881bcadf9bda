#include "dem_templates/plugin/wall/wall_rows.hpp"

#include "common/every_width.hpp"

namespace granary::dem {
namespace {

using Rows = WallRows;

// Written so that the compiler can take several rows at once.
template <RollingModel rolling, bool frozen>
[[gnu::always_inline]] inline void advance_rows(double* __restrict numbers, std::size_t n, const Rows::Frame& frame,
                                                double time_step) {
  const Turn turn = frame.turn;
  const Vector3 wall_spin = frame.spin;
  for (std::size_t k = 0; k < n; ++k) {
    const auto at = [&](std::size_t column) -> double& { return numbers[column * Rows::kMost + k]; };
    const auto vector = [&](std::size_t c) { return Vector3{at(c), at(c + 1), at(c + 2)}; };
    const auto set = [&](std::size_t c, const Vector3& v) { at(c) = v[0], at(c + 1) = v[1], at(c + 2) = v[2]; };

    const WallMaterial material{.young = at(Rows::kYoung),
                                .shear = at(Rows::kShearModulus),
                                .damping = at(Rows::kDamping),
                                .friction = at(Rows::kFriction),
                                .rolling_friction = at(Rows::kRollingFriction),
                                .cohesion = at(Rows::kCohesion)};
    const WallApproach approach{
        .radius = at(Rows::kRadius),
        .mass = at(Rows::kMass),
        .overlap = at(Rows::kOverlap),
        .normal = vector(Rows::kNormal),
        .velocity = turn.to_body(vector(Rows::kVelocity)) - cross(wall_spin, vector(Rows::kPoint)),
        .spin = turn.to_body(vector(Rows::kSpin)),
        .wall_spin = wall_spin};
    TouchHistory history{vector(Rows::kShear), vector(Rows::kRolling)};
    const WallForce pushed = wall_force<rolling, frozen>(material, approach, time_step, history);
    set(Rows::kForce, turn.to_lab(pushed.force));
    set(Rows::kTorque, turn.to_lab(pushed.torque));
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

}  // namespace

WallRows::WallRows() { numbers_.fill(1.0); }

void WallRows::add(const WallMaterial& material, const Touch& touch, const TouchHistory& history) {
  const double alone[3] = {touch.radius, touch.mass, touch.overlap};
  const double law[6] = {
      material.young,   material.shear, material.damping, material.friction, material.rolling_friction,
      material.cohesion};
  set(kRadius, alone);
  set(kNormal, touch.normal.data());
  set(kPoint, touch.point.data());
  set(kVelocity, touch.velocity);
  set(kSpin, touch.spin);
  set(kShear, history.shear.data());
  set(kRolling, history.rolling_torque.data());
  set(kYoung, law);
  set(kFriction, law + 3);
  ++size_;
}

// In whole vectors: rows beyond the last hold old numbers, which harm nothing.
void WallRows::advance(const Frame& frame, RollingModel rolling, double time_step, bool frozen) {
  constexpr std::size_t kVector = 8;
  static_assert(kMost % kVector == 0);
  const std::size_t n = (size_ + kVector - 1) / kVector * kVector;
  if (frozen) return hold(numbers_.data(), n, frame, rolling, time_step);
  switch (rolling) {
    case RollingModel::none:
      return advance_sliding(numbers_.data(), n, frame, time_step);
    case RollingModel::cdt:
      return advance_cdt(numbers_.data(), n, frame, time_step);
    case RollingModel::epsd2:
      return advance_epsd2(numbers_.data(), n, frame, time_step);
  }
}

}  // namespace granary::dem
