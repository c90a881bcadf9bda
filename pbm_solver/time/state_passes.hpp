// What the integrator does with whole states: linear combinations and sums over classes, in passes over contiguous
// memory.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "pbm_solver/time/compartment_row.hpp"

namespace granary::pbm {

/// factor * values
struct Term {
  double factor;
  const double* values;
};

/// out = base + sum of the terms, in their order. `base` null: 0. out may be base.
void combine(const double* base, std::span<const Term> terms, std::span<double> out, int threads);

/// For each block whether any number, liquid or gas is below 0.
std::vector<char> negative_blocks(const CompartmentRow& row, std::span<const double> state);

/// What a state holds, or an error amounts to, in one compartment: sums of magnitudes over its classes.
using Held = std::array<double, 4>;  ///< number, solid volume, liquid, gas
/// Of every compartment of this rank, in their order.
void sum_magnitudes(const CompartmentRow& row, std::span<const double> state, std::span<Held> sums);

}  // namespace granary::pbm
