// What a state comes to, compartment by compartment: the numbers a monitor or a person watches, and the progress line
// of them.
#pragma once

#include <vector>

#include "common/json/value.hpp"
#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/model/class_grid.hpp"
#include "pbm_solver/model/model_tables.hpp"
#include "pbm_solver/time/integrator.hpp"
#include "pbm_solver/time/snapshot.hpp"

namespace granary::pbm {

/// Diameters below which 10, 50 and 90 % of the particle volume lie [m]; 0 without particles.
struct Quantiles {
  double d10 = 0.0, d50 = 0.0, d90 = 0.0;
};

struct Summary {
  std::vector<double> number;              ///< particles, shape (X)
  std::vector<double> d10, d50, d90;       ///< of the full volume-weighted distribution [m], shape (X)
  std::vector<double> solid, liquid, gas;  ///< held [m^3], shape (X)
  std::vector<double> porosity;            ///< (liquid + gas) / (solid + liquid + gas), shape (X)
  // Outlet: the flow out of the last compartment; all 0 without flow.
  double outlet_mass_rate = 0.0;        ///< solids [kg/s]
  double outlet_number_rate = 0.0;      ///< [1/s]
  Quantiles outlet;                     ///< [m]
  double outlet_liquid_fraction = 0.0;  ///< liquid over particle volume
  std::vector<double> outlet_rate;      ///< particles by class [1/s], shape (n_classes)
  Drift drift;
  double oversize = 0.0;  ///< solids that left the grid at its top, since the start [m^3]
};

Summary summarize(const Snapshot& snapshot, const PbmCase& pbm_case, const ClassGrid& grid);

/// Mean particles of the classes: diameter [m] and, as their weight, volume with liquid and gas [m^3].
struct Sizes {
  std::vector<double> diameter, volume;
  void add(const ClassGrid& grid, Fields fields);
};
Quantiles quantiles_of(const Sizes& sizes, const ClassGrid& grid);

/// What a run has cost so far.
struct Cost {
  double wall = 0.0;  ///< [s]
  double cpu = 0.0;   ///< of all ranks and threads [s]
  WorkCount work;
};

/// The header and a line of progress.jsonl (docs/exchange_formats.md).
json::Value progress_header(const PbmCase& pbm_case, double start_time, int ranks, int threads);
json::Value progress_line(const Snapshot& snapshot, const Summary& summary, const Cost& cost);

}  // namespace granary::pbm
