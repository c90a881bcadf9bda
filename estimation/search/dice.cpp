#include <algorithm>
#include <cmath>

#include "common/units.hpp"
#include "estimation/search/methods.hpp"

namespace granary::estimation {

double Dice::uniform() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }

double Dice::normal() {
  if (spare_) {
    spare_ = false;
    return spare_normal_;
  }
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform())), angle = 2.0 * kPi * uniform();
  spare_ = true;
  spare_normal_ = radius * std::sin(angle);
  return radius * std::cos(angle);
}

int Dice::below(int n) { return std::min(static_cast<int>(uniform() * n), n - 1); }

Point Dice::anywhere(std::size_t n) {
  Point p(n);
  for (double& x : p) x = uniform();
  return p;
}

double reflected(double x) {
  x = std::abs(std::fmod(x, 2.0));
  return x > 1.0 ? 2.0 - x : x;
}

}  // namespace granary::estimation
