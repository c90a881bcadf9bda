#include "pbm_solver/time/state_passes.hpp"

#include <math.h>  // not <cmath>: the vector forms belong to the global names

#include <algorithm>

#include "common/every_width.hpp"

namespace granary::pbm {
namespace {

constexpr std::size_t kChunk = 1024;  // doubles: stays in the first cache
constexpr std::size_t kWidth = 8;
using Sums = std::array<double, kWidth>;

GRANARY_EVERY_WIDTH
void combine_chunk(const double* base, const Term* terms, std::size_t n_terms, double* out, std::size_t first,
                   std::size_t n) {
  for (std::size_t k = 0; k < n; ++k) out[first + k] = base != nullptr ? base[first + k] : 0.0;
  for (std::size_t t = 0; t < n_terms; ++t) {
    const double factor = terms[t].factor;
    const double* values = terms[t].values + first;
    for (std::size_t k = 0; k < n; ++k) out[first + k] += factor * values[k];
  }
}

GRANARY_EVERY_WIDTH
bool any_below_0(const double* values, std::size_t n) {
  int below = 0;
  for (std::size_t k = 0; k < n; ++k) below |= values[k] < 0.0 ? 1 : 0;
  return below != 0;
}

/// sums[k mod 8] += weight |value|; with eight lanes that is by lane.
GRANARY_EVERY_WIDTH
void add_magnitudes(const double* weight, const double* values, std::size_t n, double* sums) {
  std::size_t k = 0;
  for (; k + kWidth <= n; k += kWidth)
    for (std::size_t l = 0; l < kWidth; ++l) sums[l] += (weight != nullptr ? weight[k + l] : 1.0) * fabs(values[k + l]);
  for (; k < n; ++k) sums[k % kWidth] += (weight != nullptr ? weight[k] : 1.0) * fabs(values[k]);
}

}  // namespace

void combine(const double* base, std::span<const Term> terms, std::span<double> out, int threads) {
  const int n_chunks = static_cast<int>((out.size() + kChunk - 1) / kChunk);
#pragma omp parallel for schedule(static) num_threads(threads) if (threads > 1)
  for (int chunk = 0; chunk < n_chunks; ++chunk) {
    const std::size_t first = static_cast<std::size_t>(chunk) * kChunk;
    combine_chunk(base, terms.data(), terms.size(), out.data(), first, std::min(kChunk, out.size() - first));
  }
}

std::vector<char> negative_blocks(const CompartmentRow& row, std::span<const double> state) {
  std::vector<char> negative(row.blocks());
  row.for_each_block([&](std::size_t b) {
    negative[b] = any_below_0(&state[b * row.stride()], 3 * row.classes() * row.lanes()) ? 1 : 0;
  });
  return negative;
}

void sum_magnitudes(const CompartmentRow& row, std::span<const double> state, std::span<Held> sums) {
  const std::size_t each = row.classes() * row.lanes();
  row.for_each_block([&](std::size_t b) {
    const double* field = &state[b * row.stride()];
    std::array<Sums, 4> by_lane{};
    add_magnitudes(nullptr, field, each, by_lane[0].data());
    add_magnitudes(row.tables().solids.solid.data(), field, each, by_lane[1].data());
    add_magnitudes(nullptr, field + each, each, by_lane[2].data());
    add_magnitudes(nullptr, field + 2 * each, each, by_lane[3].data());
    for (std::size_t x = b * row.lanes(); x < std::min((b + 1) * row.lanes(), row.compartments()); ++x)
      for (std::size_t q = 0; q < 4; ++q) {
        sums[x][q] = row.lanes() == kWidth ? by_lane[q][x % kWidth] : 0.0;
        if (row.lanes() == 1)
          for (const double part : by_lane[q]) sums[x][q] += part;
      }
  });
}

}  // namespace granary::pbm
