// Number densities that solve the population balance exactly, and their content of each cell of a grid.
#pragma once

#include <functional>
#include <vector>

#include "pbm_solver/model/cell_average.hpp"
#include "pbm_solver/model/class_grid.hpp"

namespace granary::pbm::exact {

/// One component, start exp(-v) (one particle of mean volume 1). Volumes in units of the mean, rates of 1.
/// Constant kernel 1:  4 / (2 + t)^2 exp(-2 v / (2 + t)).   Source: [smoluchowski1916], [scott1968]
double constant_kernel(double v, double t);
/// Sum kernel u + v:  (1 - T) / (v sqrt T) exp(-(1 + T) v) I_1(2 v sqrt T),  T = 1 - exp(-t).   Source: [golovin1963]
double sum_kernel(double v, double t);
/// Breakage at the rate v into two uniform fragments, b = 2/u:  (1 + t)^2 exp(-v (1 + t)).   Source: [ziff1985]
double linear_breakage(double v, double t);

/// Two components, start exp(-x - y).
/// Constant kernel 1:  4 / (t + 2)^2 exp(-x - y) I_0(2 sqrt(t / (t + 2) x y)).   Source: [lushnikov1976]
double constant_kernel_2d(double x, double y, double t);
/// Sum kernel x + y + x' + y':  (1 - T) exp(-T m - x - y) sum_k (T m x y)^k / ((k + 1)! k!^2),
/// m = (x + y) / 2, T = 1 - exp(-2 t).   Derived from [fernandez2007]; its residual was checked numerically.
double sum_kernel_2d(double x, double y, double t);

/// Number and solids a density holds in each cell of the grid (Gauss-Legendre, on pieces even in log v).
/// With a grid of one solid the density is called with y = 0 and is one per volume of that solid.
BirthGrid cell_content(const ClassGrid& grid, const std::function<double(double, double)>& density);

/// Numbers at the pivots that hold the number and solids of the cells: each cell's content at its mean, shared as
/// births are.
std::vector<double> at_pivots(const ClassGrid& grid, const BirthGrid& content);

}  // namespace granary::pbm::exact
