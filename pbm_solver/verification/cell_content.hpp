// What a known distribution holds in each cell of a grid, and the numbers at the pivots that stand for it.
#pragma once

#include <functional>
#include <vector>

#include "pbm_solver/model/class_grid.hpp"
#include "pbm_solver/verification/cell_average.hpp"

namespace granary::pbm::exact {

/// Particles per volume of solid 1 and solid 2; with a grid of one solid it is called with y = 0 and is one per volume
/// of that solid.
using Density = std::function<double(double x, double y)>;

/// Number and solids a density holds in each cell of the grid (Gauss-Legendre, on pieces even in log v).
BirthGrid cell_content(const ClassGrid& grid, const Density& density);

/// Adds `number` particles of exactly the solids (x, y) to their cell.
void add_particles(const ClassGrid& grid, double x, double y, double number, BirthGrid& content);

/// Adds particles of one solid alone, with the first class of the other.
void add_pure(const ClassGrid& grid, int solid, const std::function<double(double v)>& density, BirthGrid& content);

/// Numbers at the pivots that hold the number and solids of the cells: each cell's content at its mean, shared as
/// births are. What a cell holds below the first pivot is put on that pivot.
std::vector<double> at_pivots(const ClassGrid& grid, const BirthGrid& content);

}  // namespace granary::pbm::exact
