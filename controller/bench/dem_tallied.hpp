// What the tallies of runs say, as quantities to be compared: rates, speeds, residence.
#pragma once

#include <vector>

#include "common/json/value.hpp"
#include "controller/bench/estimate.hpp"

namespace granary::bench {

/// The quantities of several runs of one case with different seeds; a batch is so many windows of tallies.jsonl.
///
///   collisions a-b [1/s]      for each pair of size classes (numbered from 1), and "collisions" per particle
///   impacts a [1/s]           with the rotors, for each class; and "impacts" per particle
///   impacts above 1 m/s       per particle: the first class of speeds that begins there or above
///   collision speed, impact speed [m/s]        mean normal speed at the first touch
///   speed a [m/s]             mean of the particles of a class
///   axial velocity x [m/s]    mean of a compartment
///   outflow                   share of the particles inside that leaves in a second [1/s]: one over the residence time
///
/// What is 0 throughout is left out.
/// @param tallies  for each run its lines of tallies.jsonl, the header first
std::vector<Measured> quantities(const std::vector<std::vector<json::Value>>& tallies, std::size_t windows_per_batch);

/// One of them by its name; empty if it is not there.
const Measured& quantity(const std::vector<Measured>& all, std::string_view name);

}  // namespace granary::bench
