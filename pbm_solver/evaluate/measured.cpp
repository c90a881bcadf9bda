#include "pbm_solver/evaluate/measured.hpp"

#include <array>
#include <numeric>

#include "common/math/size_distribution.hpp"
#include "pbm_solver/output/summary.hpp"

namespace granary::pbm {
namespace {

using estimation::Quantity;
using estimation::Target;

/// Compartments of a target, from first to the one before last.
std::pair<std::size_t, std::size_t> compartments_of(const Target& t, std::size_t count) {
  if (t.compartment == estimation::kEverywhere) return {0, count};
  const std::size_t one = t.compartment == estimation::kOutlet ? count - 1 : static_cast<std::size_t>(t.compartment);
  return {one, one + 1};
}

/// All that the target's compartments hold together.
struct Content {
  double number = 0.0;
  std::array<double, 4> volume{};  ///< solid 1, solid 2, liquid, gas [m^3]
  Sizes sizes;
};

Content content_of(const Target& t, const Snapshot& s, const ClassGrid& grid) {
  const std::size_t n = grid.size();
  const auto [first, last] = compartments_of(t, s.number.size() / n);
  Content held;
  for (std::size_t x = first; x < last; ++x) {
    const auto part = [&](const std::vector<double>& all) { return std::span(all).subspan(x * n, n); };
    const Fields f{part(s.number), part(s.liquid), part(s.gas)};
    held.number = std::accumulate(f.number.begin(), f.number.end(), held.number);
    const std::array<double, 4> here = holdup(grid, f);
    for (std::size_t q = 0; q < 4; ++q) held.volume[q] += here[q];
    held.sizes.add(grid, f);
  }
  return held;
}

std::vector<double> shares(const Target& t, const Content& held, const ClassGrid& grid) {
  const double width = log_width_of_pivots(grid.axis(0).pivots(), grid.axis(1).pivots());
  const auto below = shares_below(held.sizes.diameter, held.sizes.volume, t.edges, width);
  std::vector<double> between;
  for (std::size_t k = 1; k < below.size(); ++k) between.push_back(below[k] - below[k - 1]);
  return between;
}

double ratio(double part, double whole) { return whole > 0.0 ? part / whole : 0.0; }

}  // namespace

std::vector<double> measured(const Target& t, const Snapshot& state, const PbmCase& c, const ClassGrid& grid) {
  const Content held = content_of(t, state, grid);
  const auto& [solid_1, solid_2, liquid, gas] = held.volume;
  const double mass = c.materials.solid_density[0] * solid_1 + c.materials.solid_density[1] * solid_2;
  const double flow =
      t.compartment == estimation::kOutlet ? c.compartments.count / c.compartments.residence_time.value_or(1e300) : 1.0;
  switch (t.quantity) {
    case Quantity::d10:
      return {quantiles_of(held.sizes, grid).d10};
    case Quantity::d50:
      return {quantiles_of(held.sizes, grid).d50};
    case Quantity::d90:
      return {quantiles_of(held.sizes, grid).d90};
    case Quantity::number:
      return {flow * held.number};
    case Quantity::solid_mass:
      return {flow * mass};
    case Quantity::porosity:
      return {ratio(liquid + gas, solid_1 + solid_2 + liquid + gas)};
    case Quantity::liquid_content:
      return {ratio(c.materials.liquid_density * liquid, mass)};
    case Quantity::distribution:
      return shares(t, held, grid);
  }
  return {};
}

}  // namespace granary::pbm
