// A campaign's estimation as a problem of its own: the cases of every experiment, with the rates known so far.
#pragma once

#include <vector>

#include "common/result.hpp"
#include "controller/campaign/campaign.hpp"
#include "estimation/problem/problem.hpp"

namespace granary::estimating {

/// A stretch of the process and the rates it ran with: a PBM burst, once it is over.
struct Stretch {
  double until = 0.0;  ///< process time [s]; of the last one: it goes on to the end of the process
  pbm::DemRates rates;
};

/// The estimation of `campaign`, which must have one. An experiment with rates of its own is one segment; one that
/// takes the campaign's is a segment for each stretch of its history, in rising order of `until`; one that needs no
/// DEM is one segment. Error: an experiment needs rates, and there are none.
Result<estimation::Problem> problem_of(const campaign::Campaign& campaign, const std::vector<Stretch>& history = {});

/// The cases of the workflow itself over a history, one a stretch, each to be run from the end of the one before.
std::vector<pbm::PbmCase> segments_of(const pbm::PbmCase& balance, const std::vector<Stretch>& history);

}  // namespace granary::estimating
