// The coupled state in few numbers, and how far two of them are apart: the last test before a campaign is called
// steady.
#pragma once

#include <string>
#include <vector>

#include "common/json/value.hpp"

namespace granary::coupling {

/// One DEM burst, at real sizes.
struct DemSummary {
  double start_time = 0.0, end_time = 0.0;  ///< what was measured, DEM clock [s]
  double coarse_graining = 1.0;             ///< DEM diameter / real diameter
  double particles = 0.0;                   ///< DEM particles, mean over the windows
  double collision_frequency = 0.0;         ///< collisions a particle takes part in per time [1/s]
  double impact_frequency = 0.0;            ///< impacts per particle and time [1/s]
  double collisions = 0.0, impacts = 0.0;   ///< how many were counted: their counting error is 1/sqrt
  std::vector<double> class_diameter;       ///< real [m], shape (n_classes)
  std::vector<double> mean_speed;           ///< [m/s], shape (n_classes); NaN where the class is too thin to say
  std::vector<double> mean_speed_error;     ///< standard error [m/s], the larger of that by counting and that by the
                                            ///< scatter of the windows; shape (n_classes)

  bool operator==(const DemSummary&) const;  ///< NaN equals NaN
};

/// One PBM state.
struct PbmSummary {
  double time = 0.0;           ///< process clock [s]
  std::vector<double> d50;     ///< by volume [m], shape (n_compartments); 0 where empty
  std::vector<double> number;  ///< particles, shape (n_compartments)

  bool operator==(const PbmSummary&) const = default;
};

/// A whole round: the DEM burst, and the PBM burst that took its rates.
struct CoupledSummary {
  DemSummary dem;
  PbmSummary pbm;

  bool operator==(const CoupledSummary&) const = default;
};

/// One property in two summaries.
struct Difference {
  std::string what, where;  ///< "d50_m", "compartment 2"
  double before = 0.0, after = 0.0;
  double change = 0.0;  ///< (after - before) / |before|, the denominator held above a floor [-]
  double noise = 0.0;   ///< standard error of `change` by counting [-]; 0 for the PBM
};

struct Change {
  std::vector<Difference> differences;

  /// The largest |change| that is beyond `tolerance` and beyond `significance` standard errors; nullptr if none is.
  const Difference* beyond(double tolerance, double significance) const;
  /// The largest |change| of all; nullptr if nothing could be compared.
  const Difference* largest() const;
};

/// Mean speeds are compared class by class (a class is a quantile of the size distribution), if there are as many.
/// Compartments that hold less than 0.1 % of the fullest in both states are left out.
Change compare(const CoupledSummary& before, const CoupledSummary& after);
Change compare(const DemSummary& before, const DemSummary& after);
Change compare(const PbmSummary& before, const PbmSummary& after);

json::Value to_json(const Difference& difference);
json::Value to_json(const DemSummary& summary);
json::Value to_json(const PbmSummary& summary);
DemSummary dem_summary_from_json(const json::Value& value);
PbmSummary pbm_summary_from_json(const json::Value& value);

}  // namespace granary::coupling
