// Where to cut a line so that its slices bear equal loads. Pure.
#pragma once

#include <span>
#include <vector>

namespace granary::dem {

/// New cuts of [0, 1] between the slices of `now`, each where its share of the load ends, but kept between the old cuts
/// on its left and right: then nothing is farther than one slice from where it belongs.
///
/// @param load   of equal parts of [0, 1], not negative
/// @param now    cuts, ascending, from 0 to 1                         n_slices + 1
/// @param least  width that each slice keeps at least, if it has it now
/// @return       as `now`; `now` itself if there is no load
std::vector<double> even_cuts(std::span<const double> load, const std::vector<double>& now, double least);

/// Load of the heaviest slice over the mean of all; 1 if there is no load.
double imbalance(std::span<const double> load, const std::vector<double>& cuts);

}  // namespace granary::dem
