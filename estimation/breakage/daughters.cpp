#include "estimation/breakage/daughters.hpp"

#include <cmath>
#include <map>

namespace granary::estimation {

std::vector<MeanDaughter> mean_daughters(const std::vector<WeightedSplits>& groups, int from, int to) {
  constexpr double kBinsPerOctave = 20.0;
  struct Bin {
    double number = 0.0, volume = 0.0;
  };
  std::map<long, Bin> bins;
  double n = 0.0;
  for (const auto& [splits, weight] : groups)
    for (const Split& split : *splits) {
      if (split.parent < from || split.parent > to) continue;
      n += weight;
      for (const int daughter : split.daughters) {
        const double share = static_cast<double>(daughter) / split.parent;
        Bin& bin = bins[std::lround(kBinsPerOctave * std::log2(share))];
        bin.number += weight;
        bin.volume += weight * share;
      }
    }
  std::vector<MeanDaughter> daughters;
  double whole = 0.0;
  for (const auto& [at, bin] : bins) {
    daughters.push_back({bin.volume / bin.number, bin.number / n});
    whole += bin.volume / n;
  }
  for (MeanDaughter& daughter : daughters) daughter.number /= whole;  // round-off only
  return daughters;
}

}  // namespace granary::estimation
