#include "dem_templates/plugin/bond/bond_rows.hpp"

#include <algorithm>

#include "common/every_width.hpp"

namespace granary::dem {
namespace {

// The columns: the state first, then what stays as it is.
enum Column : std::size_t {
  kNormal = 0,
  kShear = 3,
  kBend = 6,
  kTwist = 9,
  kLength = 10,
  kStrength,
  kNormalK,
  kShearK,
  kBendK,
  kTwistK,
  kNormalC,
  kShearC,
  kBendC,
  kTwistC,
  kPerArea,
  kBendStress,
  kShare
};

struct Rows {
  double* numbers;     // at the first row
  std::size_t stride;  // from column to column
  double* motion;      // of the block
  double* load;
  double* tension;
  double* overload;
};

// Compiled for the width of each processor. Every row is worked out alike, with no branch in it: gcc makes vectors.
template <bool frozen, bool damped>
[[gnu::always_inline]] inline void advance_rows(const Rows& r, std::size_t n, const BondMaterial material,
                                                double time_step) {
  const std::size_t w = r.stride;
  constexpr std::size_t b = BondRows::kBlock;
  double* const x = r.numbers;
  const double* const m = r.motion;
  double* const out = r.load;
#pragma GCC ivdep
  for (std::size_t k = 0; k < n; ++k) {
    const auto at = [&](std::size_t c) { return x[c * w + k]; };
    Bond bond{.partner = 0.0,
              .radius = 0.0,
              .length = at(kLength),
              .strength = at(kStrength),
              .normal = {at(kNormal), at(kNormal + 1), at(kNormal + 2)},
              .shear = {at(kShear), at(kShear + 1), at(kShear + 2)},
              .bend = {at(kBend), at(kBend + 1), at(kBend + 2)},
              .twist = at(kTwist)};
    const BondSection section{.normal = at(kNormalK),
                              .shear = at(kShearK),
                              .bend = at(kBendK),
                              .twist = at(kTwistK),
                              .normal_damping = at(kNormalC),
                              .shear_damping = at(kShearC),
                              .bend_damping = at(kBendC),
                              .twist_damping = at(kTwistC),
                              .per_area = at(kPerArea),
                              .bend_stress = at(kBendStress),
                              .share = at(kShare)};
    const BondMotion motion{.between = {m[k], m[b + k], m[2 * b + k]},
                            .velocity = {m[3 * b + k], m[4 * b + k], m[5 * b + k]},
                            .spin = {m[6 * b + k], m[7 * b + k], m[8 * b + k]},
                            .far_spin = {m[9 * b + k], m[10 * b + k], m[11 * b + k]}};
    const BondLoad load = bond_load(section, motion, time_step, frozen, damped, bond);
    r.overload[k] = bond_overload(material, section, load.tension, bond);
    r.tension[k] = load.tension;
    for (std::size_t d = 0; d < 3; ++d) {
      out[d * b + k] = load.force[d];
      out[(3 + d) * b + k] = load.torque[d];
      out[(6 + d) * b + k] = load.far_torque[d];
      if (frozen) continue;
      x[(kNormal + d) * w + k] = bond.normal[d];
      x[(kShear + d) * w + k] = bond.shear[d];
      x[(kBend + d) * w + k] = bond.bend[d];
    }
    if (!frozen) x[kTwist * w + k] = bond.twist;
  }
}

GRANARY_EVERY_WIDTH void advance_damped(const Rows& r, std::size_t n, const BondMaterial& material, double dt) {
  advance_rows<false, true>(r, n, material, dt);
}
GRANARY_EVERY_WIDTH void advance_undamped(const Rows& r, std::size_t n, const BondMaterial& material, double dt) {
  advance_rows<false, false>(r, n, material, dt);
}
void hold(const Rows& r, std::size_t n, const BondMaterial& material, double dt) {
  advance_rows<true, true>(r, n, material, dt);
}

}  // namespace

BondRows::Block::Block() {
  for (auto& numbers : motion) numbers.fill(1.0);
}

void BondRows::make_room() {
  const std::size_t room = std::max(kBlock, 2 * room_);
  std::vector<double> wider(kColumns * room, 1.0);
  for (std::size_t c = 0; c < kColumns && room_ > 0; ++c) std::copy_n(column(c), size_, wider.data() + c * room);
  numbers_ = std::move(wider);
  room_ = room;
}

void BondRows::add(const Bond& bond, const BondSection& s) {
  if (size_ == room_) make_room();
  const double values[kColumns] = {bond.normal[0], bond.normal[1],   bond.normal[2],  bond.shear[0],  bond.shear[1],
                                   bond.shear[2],  bond.bend[0],     bond.bend[1],    bond.bend[2],   bond.twist,
                                   bond.length,    bond.strength,    s.normal,        s.shear,        s.bend,
                                   s.twist,        s.normal_damping, s.shear_damping, s.bend_damping, s.twist_damping,
                                   s.per_area,     s.bend_stress,    s.share};
  for (std::size_t c = 0; c < kColumns; ++c) column(c)[size_] = values[c];
  ++size_;
}

void BondRows::remove(std::size_t k) {
  --size_;
  for (std::size_t c = 0; c < kColumns; ++c) column(c)[k] = column(c)[size_];
}

void BondRows::copy_state(std::size_t k, Bond& bond) const {
  for (std::size_t d = 0; d < 3; ++d) {
    bond.normal[d] = column(kNormal + d)[k];
    bond.shear[d] = column(kShear + d)[k];
    bond.bend[d] = column(kBend + d)[k];
  }
  bond.twist = column(kTwist)[k];
}

BondSection BondRows::section(std::size_t k) const {
  return {.normal = column(kNormalK)[k],
          .shear = column(kShearK)[k],
          .bend = column(kBendK)[k],
          .twist = column(kTwistK)[k],
          .normal_damping = column(kNormalC)[k],
          .shear_damping = column(kShearC)[k],
          .bend_damping = column(kBendC)[k],
          .twist_damping = column(kTwistC)[k],
          .per_area = column(kPerArea)[k],
          .bend_stress = column(kBendStress)[k],
          .share = column(kShare)[k]};
}

// Rows are worked out in whole vectors; those beyond the last bond hold old numbers, which harm nothing.
std::size_t BondRows::advance(const BondMaterial& material, double time_step, bool frozen, std::size_t first,
                              Block& block) {
  constexpr std::size_t kVector = 8;
  const std::size_t n = std::min(kBlock, size_ - first), whole = (n + kVector - 1) / kVector * kVector;
  const Rows rows{numbers_.data() + first, room_, block.motion[0].data(), block.load[0].data(), block.tension.data(),
                  block.overload.data()};
  if (frozen)
    hold(rows, whole, material, time_step);
  else if (material.damping > 0.0)
    advance_damped(rows, whole, material, time_step);
  else
    advance_undamped(rows, whole, material, time_step);
  return n;
}

}  // namespace granary::dem
