// The class kernels of the bench: a table of DEM rates between size classes, as cases have it and as a plain code reads
// it.
#pragma once

#include <vector>

#include "pbm_solver/model/class_grid.hpp"

namespace granary::pbm::bench {

/// Gives the case a DEM table of `n_classes` size classes that are evenly spaced over ln v of its grid, and the kernel
/// that reads it class by class. C_ab = rate (d_a + d_b)^3 times a factor between 0.5 and 1.5 that varies from entry to
/// entry as counted collisions do: no structure to exploit but the classes.
/// @param rate  [1/s]
void set_class_table(PbmCase& pbm_case, int n_classes, double rate);

/// An aggregation kernel as a plain table: beta between k and m in compartment x is
/// scale[x] rate[class_of[k]][class_of[m]].
struct ClassTable {
  std::size_t size = 1;               ///< number of kernel classes
  std::vector<std::size_t> class_of;  ///< of each class of the grid, by its dry solid volume
  std::vector<double> rate;           ///< [m^3/s], shape (size, size)
  std::vector<double> scale;          ///< by compartment [1/m^3]
};

/// The kernel of a case: constant is one class; dem is by the classes' centres, with borders halfway between them in
/// ln d. Other kernels, and efficiencies other than constant, are the caller's mistake (asserted).
ClassTable class_table_of(const PbmCase& pbm_case, const ClassGrid& grid);

}  // namespace granary::pbm::bench
