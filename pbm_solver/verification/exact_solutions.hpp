// Distributions that solve the population balance exactly. Volumes in units of the start's mean, rates of 1, one
// particle at the start unless said otherwise. Each is held against its moments and the balance itself in
// tests/numerics.
#pragma once

#include "pbm_solver/verification/cell_content.hpp"

namespace granary::pbm::exact {

// Aggregation, one solid, start exp(-v).

/// Constant kernel 1:  4 / (2 + t)^2 exp(-2 v / (2 + t)).   Source: [smoluchowski1916], [scott1968]
double constant_kernel(double v, double t);
/// Sum kernel u + v:  (1 - T) / (v sqrt T) exp(-(1 + T) v) I_1(2 v sqrt T),  T = 1 - exp(-t).   Source: [golovin1963]
double sum_kernel(double v, double t);
/// Product kernel u v, before the gel point t = 1/2:  exp(-(1 + t) v) sum_k t^k v^(3k) / ((k + 1)! (2k + 1)!).
/// Source: [scott1968]
double product_kernel(double v, double t);

// Aggregation, one solid, start with particles of size 1 alone: the number of particles of size k = 1, 2, ...

/// Constant kernel:  (t/2)^(k-1) / (1 + t/2)^(k+1).   Source: [smoluchowski1916]
double constant_kernel_count(int k, double t);
/// Sum kernel (Borel's distribution):  (1 - T) (k T)^(k-1) exp(-k T) / k!,  T = 1 - exp(-t).   Source: [golovin1963]
double sum_kernel_count(int k, double t);
/// Product kernel, before the gel point t = 1:  k^(k-2) t^(k-1) exp(-k t) / k!.   Source: [scott1968]
double product_kernel_count(int k, double t);

// Aggregation, two solids.

/// Constant kernel 1, start exp(-x - y):  4 / (t + 2)^2 exp(-x - y) I_0(2 sqrt(t / (t + 2) x y)).
/// Source: [lushnikov1976]
double constant_kernel_2d(double x, double y, double t);
/// Constant kernel 1, start 16 X Y exp(-2 X - 2 Y) / (a b) with X = x/a, Y = y/b (means a and b); k = t / (t + 2):
///   8 / (a b sqrt(t) (t + 2)^(3/2)) exp(-2 X - 2 Y) (I_0(z) - J_0(z)),  z = 4 k^(1/4) sqrt(X Y).
/// Source: [gelbard1978]
double constant_kernel_gamma_2d(double x, double y, double mean_x, double mean_y, double t);
/// Constant kernel 1; the start has a share a of pure particles exp(-x) of solid 1 and b = 1 - a of exp(-y) of solid 2.
/// With k = t / (t + 2), c = k^2 a b, z = 2 sqrt(c x y), f = 4 / (t + 2)^2 there are then
///   mixed           f exp(-(1 - k a) x - (1 - k b) y) [(a sqrt(c x/y) + b sqrt(c y/x)) I_1(z) + 2 k a b I_0(z)]
///   pure solid 1    f a exp(-(1 - k a) x)        and likewise with b for solid 2.
/// Derived from the Laplace transform n~ = f F / (1 - k F), F = a / (1 + p) + b / (1 + q).
double constant_kernel_mixed(double x, double y, double share_1, double t);
double constant_kernel_pure(double x, double share, double t);
/// Sum kernel x + y + x' + y', start exp(-x - y):  (1 - T) exp(-T m - x - y) sum_k (T m x y)^k / ((k + 1)! k!^2),
/// m = (x + y) / 2, T = 1 - exp(-2 t).   Derived from [fernandez2007]; its residual was checked numerically.
double sum_kernel_2d(double x, double y, double t);
/// Product kernel (x + y) (x' + y'), start 4 exp(-2 x - 2 y), before the gel point t = 2/3; v = x + y:
///   exp(-t v - 2 v) / v sum_k (t v)^k 4^(k+1) / (k + 1)! sum_{j=0}^{k+1} C(k+1, j) x^(2k+1-j) / (2k+1-j)! y^(k+j) /
///   (k+j)!.   Derived as the sum kernel's.
double product_kernel_2d(double x, double y, double t);

// Breakage into two uniform fragments, b = 2/u, one solid.

/// Rate v, start exp(-v):  (1 + t)^2 exp(-v (1 + t)).   Source: [ziff1985]
double linear_breakage(double v, double t);
/// Rate v, start with one particle of size 1, of which exp(-t) are left; the fragments:  exp(-t v) (2 t + t^2 (1 - v)).
/// Source: [ziff1985]
double linear_breakage_fragments(double v, double t);
/// Rate v^2, start exp(-v):  exp(-t v^2 - v) (1 + 2 t (1 + v)).   Source: [ziff1985]
double square_breakage(double v, double t);

/// Two solids, rate 1, b = 2/(x' y'), start exp(-x - y), by cell: each cut multiplies both solids by independent
/// uniform shares, so n = exp(-t) sum_k (2 t)^k / k! g_k(x) g_k(y) with g_k(x) = int_0^inf exp(-x e^s) s^(k-1) / (k-1)!
/// ds.
BirthGrid constant_breakage_2d(const ClassGrid& grid, double t);

// Aggregation with breakage, and with flow, one solid.

/// Constant kernel 1 and rate s v, b = 2/u, start exp(-v):  P^2 exp(-P v), P = Q (1 + Q tanh(Q t/2)) / (Q + tanh(Q
/// t/2)), Q = sqrt(2 s), to the steady state Q^2 exp(-Q v).   Source: [blatz1945], [mccoy1998]
double balanced(double v, double s, double t);
/// Constant kernel 1 and rate v/2, b = 2/u, start 4 v exp(-2 v): two exponentials.   Source: [lage2002]
double balanced_gamma(double v, double t);
/// Steady state of a stirred tank with turnover r, one particle of exp(-v) fed per 1/r, constant kernel 1; c^2 = r^2 +
/// 2 r, b = r / c^2:   c b exp(-(1 - b) v) (I_0(b v) - I_1(b v)).   Derived from the Laplace transform
///   n~ = c (1 - sqrt(1 - 2 b / (1 + p))).
double stirred_tank(double v, double turnover);
/// Share of its final content in tank m = 0, 1, ... of a row that has been fed since t = 0; turnover r of each tank:
///   1 - exp(-r t) sum_{k<=m} (r t)^k / k!.
double tank_filling(int tank, double turnover, double t);

}  // namespace granary::pbm::exact
