// What a resolved breakage looked like: which fragments there were at each sample, and which were split since the last.
// Read from fragments.jsonl (docs/dem_styles.md); knows no DEM.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::estimation {

/// A fragment that is in more than one piece since the last sample. Sizes in primary spheres.
struct Split {
  int parent = 0;
  std::vector<int> daughters;  ///< they add up to the parent
  std::string cause;           ///< "impeller", "chopper", "particles", ...
  int agglomerate = 0;         ///< it was part of; 0: not told
};

struct FragmentSample {
  double time = 0.0;          ///< [s]
  std::map<int, long> alive;  ///< fragments of each size
  std::vector<Split> splits;  ///< since the sample before
};
using FragmentHistory = std::vector<FragmentSample>;

/// From the lines of fragments.jsonl. Errors: times that do not rise; a split whose daughters are not the parent.
Result<FragmentHistory> history_of(const std::vector<json::Value>& lines, const std::string& file);

/// Fragments of a range of sizes and what became of them over a stretch of time.
struct SizeRecord {
  int from = 0, to = 0;                ///< sizes, both included
  double mean_size = 0.0;              ///< weighted with the exposure
  double exposure = 0.0;               ///< [s]: sum over fragments of the time each was there
  std::map<std::string, long> splits;  ///< by cause
  long all_splits() const;
};

/// One record for each class of sizes, [bounds[c], bounds[c + 1]). A fragment counts from sample to sample; the
/// exposure of those that were split in between is that of a constant rate r that splits a share p within dt:
/// r = -ln(1 - p) / dt, so that splits / exposure is r itself and not only to first order in r dt.
std::vector<SizeRecord> records_of(const FragmentHistory& history, const std::vector<int>& bounds);

/// The history of each agglomerate by itself, at the same times: what scatters independently. Empty if the splits do
/// not say of which agglomerate they are, or if it does not begin with `whole` alone.
std::vector<FragmentHistory> by_agglomerate(const FragmentHistory& history, int whole);

/// Sums over fragments and intervals that records are made of: those of several histories add up.
struct SizeSums {
  double time = 0.0;       ///< fragments times time, as if none were split [s]
  double size_time = 0.0;  ///< the same times size
  double began = 0.0;      ///< fragments that were there at the start of an interval
  std::map<std::string, long> splits;
  void add(const SizeSums& other, long times);
};
/// shape (classes)
std::vector<SizeSums> sums_of(const FragmentHistory& history, const std::vector<int>& bounds);
std::vector<SizeRecord> records_of(const std::vector<SizeSums>& sums, const std::vector<int>& bounds);

/// Classes of sizes that grow by about a fifth: {2, 3, 4, 5, 6, 8, 10, ..., largest, largest + 1}; the last class is
/// the whole agglomerates alone.
std::vector<int> size_bounds(int largest);

}  // namespace granary::estimation
