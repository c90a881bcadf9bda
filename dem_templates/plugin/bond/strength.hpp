// The scatter of the bonds' strengths.
#pragma once

#include <cstdint>

namespace granary::dem {

enum class StrengthScatter { none, weibull, normal };

/// Strength of one bond over the mean, of mean 1: by Weibull with modulus m (1 - exp(-(x Gamma(1 + 1/m))^m)), or normal
/// with a standard deviation of `spread` (nothing below a tenth). Depends on nothing but its arguments, so that it is
/// the same on any number of ranks.
double bond_strength(StrengthScatter scatter, double spread, std::uint64_t seed, std::int64_t tag,
                     std::int64_t far_tag);

/// A random number in [0, 1) that depends on nothing but its arguments.
double uniform_random(std::uint64_t seed, std::uint64_t stream, std::uint64_t n);

}  // namespace granary::dem
