#include "dem_templates/plugin/bond/strength.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace granary::dem {
namespace {

std::uint64_t mixed(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

// Mixing as in splitmix64: G. L. Steele, D. Lea, C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA
// 2014.
double uniform_random(std::uint64_t seed, std::uint64_t stream, std::uint64_t n) {
  return static_cast<double>(mixed(mixed(mixed(seed) ^ stream) ^ n) >> 11) * 0x1p-53;
}

double bond_strength(StrengthScatter scatter, double spread, std::uint64_t seed, std::int64_t tag,
                     std::int64_t far_tag) {
  if (scatter == StrengthScatter::none) return 1.0;
  const auto stream = static_cast<std::uint64_t>(std::min(tag, far_tag));
  const auto n = static_cast<std::uint64_t>(std::max(tag, far_tag));
  const double u = 1.0 - uniform_random(seed, stream, 2 * n);  // in (0, 1]
  if (scatter == StrengthScatter::weibull)
    return std::pow(-std::log(u), 1.0 / spread) / std::tgamma(1.0 + 1.0 / spread);
  const double angle = 2.0 * std::numbers::pi * uniform_random(seed, stream, 2 * n + 1);
  return std::max(0.1, 1.0 + spread * std::sqrt(-2.0 * std::log(u)) * std::cos(angle));
}

}  // namespace granary::dem
