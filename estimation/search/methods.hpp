// The methods behind make_search(), and what they share. Sources beside each.
#pragma once

#include <cstdint>
#include <memory>
#include <random>

#include "estimation/search/search.hpp"

namespace granary::estimation {

std::unique_ptr<Search> make_cma_es(const Point& start, std::uint64_t seed);
std::unique_ptr<Search> make_differential_evolution(const Point& start, std::uint64_t seed);
std::unique_ptr<Search> make_ensemble_kalman(const Point& start, std::uint64_t seed);
/// step: of the first differences, in the unit cube.
std::unique_ptr<Search> make_least_squares(const Point& start, std::uint64_t seed, double step = 0.05);
std::unique_ptr<Search> make_hybrid(const Point& start, std::uint64_t seed, bool near);

/// Our own normal and uniform numbers: those of <random> differ from library to library, and a seed must mean the same
/// trials everywhere.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : bits_(seed) {}
  double uniform();                         ///< in [0, 1)
  double normal();                          ///< mean 0, variance 1 (Box and Muller)
  int below(int n);                         ///< 0 .. n - 1
  std::uint64_t seed() { return bits_(); }  ///< of other dice
  Point anywhere(std::size_t n);            ///< in the unit cube

 private:
  std::mt19937_64 bits_;
  bool spare_ = false;
  double spare_normal_ = 0.0;
};

/// Back into [0, 1], mirrored at the bounds: a point outside stands for one as far inside.
double reflected(double x);

}  // namespace granary::estimation
