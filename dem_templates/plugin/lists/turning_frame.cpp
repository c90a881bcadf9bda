#include "dem_templates/plugin/lists/turning_frame.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/every_width.hpp"

namespace granary::dem {
namespace {

struct Then {
  const double *a, *b, *c;
};

// Every particle comes through here in every step: written so that the compiler can take several at once. Numbers that
// are not negative are in the order of their bits, and what is no number comes last.
GRANARY_EVERY_WIDTH double farthest2(const double* a, const double* b, const double* c, std::size_t n, const Then& then,
                                     double cosine, double sine) {
  std::int64_t farthest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double da = a[3 * i] - then.a[i];
    const double db = b[3 * i] - (cosine * then.b[i] - sine * then.c[i]);
    const double dc = c[3 * i] - (sine * then.b[i] + cosine * then.c[i]);
    const double moved2 = da * da + db * db + dc * dc;
    const std::int64_t bits = std::bit_cast<std::int64_t>(moved2) & std::numeric_limits<std::int64_t>::max();
    farthest = farthest > bits ? farthest : bits;
  }
  return std::bit_cast<double>(farthest);
}

}  // namespace

void TurningFrame::start(const double* places, std::size_t n) {
  for (std::vector<double>* at : {&at_a_, &at_b_, &at_c_}) at->resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    at_a_[i] = places[3 * i + a_];
    at_b_[i] = places[3 * i + b_];
    at_c_[i] = places[3 * i + c_];
  }
}

double TurningFrame::farthest_moved(const double* places, std::size_t n, double angle) const {
  constexpr double kBeyondAll = std::numeric_limits<double>::infinity();
  if (n != at_a_.size()) return kBeyondAll;
  if (n == 0) return 0.0;
  const double moved2 = farthest2(places + a_, places + b_, places + c_, n, {at_a_.data(), at_b_.data(), at_c_.data()},
                                  std::cos(angle), std::sin(angle));
  return std::isnan(moved2) ? kBeyondAll : std::sqrt(moved2);
}

// |v - w e x r|^2 = |v|^2 - 2 w e . (r x v) + w^2 |e x r|^2
std::vector<double> TurningFrame::largest_speeds2(const double* places, const double* velocities, std::size_t n,
                                                  std::span<const double> rates) const {
  std::vector<double> largest(rates.size(), 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const double *x = places + 3 * i, *v = velocities + 3 * i;
    const double speed2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2], twice_spin = 2.0 * (x[b_] * v[c_] - x[c_] * v[b_]);
    const double lever2 = x[b_] * x[b_] + x[c_] * x[c_];
    for (std::size_t k = 0; k < rates.size(); ++k)
      largest[k] = std::max(largest[k], speed2 - rates[k] * twice_spin + rates[k] * rates[k] * lever2);
  }
  return largest;
}

}  // namespace granary::dem
