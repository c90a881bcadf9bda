// What is done for all lanes at once: the inner loops of the rates, compiled for every width of vector and chosen when
// the program starts. Plain pointers, no owners, no allocation. W = lanes of a block (1 or kLanes); [.][W] arrays are
// contiguous.
//
// Arrays of moments, "packs": W = 8: [class][5][8]; W = 1: [class][8], five in use (simd/lanes.hpp).
#pragma once

namespace granary::pbm::simd {

/// Tables of one grid that every block shares.
struct GridView {
  int n1 = 0, n2 = 0;
  const double *pivot_1 = nullptr, *pivot_2 = nullptr;  ///< [m^3], shapes (n1), (n2)
};

/// Deaths by a table over groups, and what lands above the grid.
struct GroupView {
  int n_groups = 0;
  const int* group = nullptr;  ///< by class
  int n_tops_1 = 0, n_tops_2 = 0;
  const int *top_1 = nullptr, *top_2 = nullptr;  ///< distinct values of the highest partner along each solid, rising
  const int *top_of_1 = nullptr, *top_of_2 = nullptr;  ///< which of them a row and a column has, shapes (n1), (n2)
};

/// Row i1 with rows i2 .. i2 + rows - 1 below it, whose sums fall into one row of cells (n1: above the grid); or with
/// itself, i2 = i1.
struct PairBlock {
  static constexpr int most_rows = 4;
  int i1, i2, rows, cells;
};

/// All pairs of classes, block after block; within a block column j after column. beta of column j: for each partner
/// m < j that of (i1, j) with (i2, m) of each row i2, then that of (i2, j) with (i1, m) of each; at the end that of
/// (i1, j) with (i2, j) of each. Of a row with itself: (i1, j) with (i1, m), m <= j.
struct PairView {
  const PairBlock* blocks = nullptr;
  int n_blocks = 0;
  const int* columns = nullptr;  ///< of each j: how many ranges of partners, and (first, last, cell) of each
  const int* leaving = nullptr;  ///< of each j: its first partner whose sum with it is above the grid; beyond j: none
  const double* beta = nullptr;  ///< [pair][W]
};

/// Weights of fragments on the pivots, per broken parent. Either products of two solids' weights, or lists.
struct FragmentView {
  const double *along_1 = nullptr, *along_2 = nullptr;  ///< [pivot][parent], shapes (n1, n1), (n2, n2); null: lists
  double times = 2.0;                                   ///< on the products
  const int *first = nullptr, *to = nullptr;            ///< list of parent k: first[k] .. first[k + 1] - 1
  const double* weight = nullptr;
  const double* diagonal = nullptr;  ///< what of a parent's fragments stays in its class
};

struct Operations {
  /// packs = weight (N, N s1, N s2, L, G) of each class. weight: [class][W] or null for 1.
  void (*load)(const GridView& grid, const double* number, const double* liquid, const double* gas,
               const double* weight, double* packs);
  /// Births of a plan added to `births`: symmetric form, coefficient C[g][g'] [groups^2][W]. slots: shape
  /// (plan.slots()) packs, the first n_classes filled by load().
  void (*births)(const int* code, const double* coefficient, double* slots, double* births);
  /// The same for beta = f g' + g f' with the factors in two sets of packs.
  void (*births_of_two)(const int* code, const double* coefficient, double* slots_f, double* slots_g, double* births);
  /// Deaths by group table: death += sum_m C[g_k][g_m] n_m [1/s], shape [class][W]; and the moments of pairs above the
  /// grid, above[5][W] (W = 1: [8]). other: packs of the partners (the same as packs for a symmetric form). scratch:
  /// see group_scratch().
  void (*deaths)(const GridView& grid, const GroupView& groups, const double* coefficient, const double* packs,
                 const double* other, double* scratch, double* death, double* above);
  /// Births and deaths of every pair, one by one. scratch: [class][W].
  void (*direct)(const GridView& grid, const PairView& pairs, const double* packs, double* scratch, double* births,
                 double* death, double* above);
  /// Adds births, shared between the pivots around their means, to the rates and takes away death * weight * state.
  /// rates_*: [class][W].
  void (*share)(const GridView& grid, const double* births, double* rate_number, double* rate_liquid, double* rate_gas);
  void (*take_deaths)(int n_classes, const double* death, const double* weight, const double* number,
                      const double* liquid, const double* gas, double* rate_number, double* rate_liquid,
                      double* rate_gas);
  /// With b the fragments' weights, S the selection rate [class][W] and s a scale by class (null: 1), in both z_k = S_k
  /// y_k / s_k:
  ///   add_breakage     out_d += factor s_d (sum_k b_dk z_k - z_d)
  ///   solve_breakage   y - gamma s (b z - z) = r, solved in place from the largest class down (b is triangular)
  /// scratch: 2 n_classes [W].
  void (*add_breakage)(const GridView& grid, const FragmentView& fragments, const double* selection,
                       const double* scale, double factor, const double* in, double* scratch, double* out);
  void (*solve_breakage)(const GridView& grid, const FragmentView& fragments, const double* selection,
                         const double* scale, double gamma, double* scratch, double* in_out);
  /// out += turnover (in of the lane before - in), lane by lane: flow down the row of compartments. carry: what enters
  /// lane 0, shape (n) (null: nothing).
  void (*flow)(int n, const double* turnover, const double* in, const double* carry, double* out);
};

/// Doubles that deaths() wants as scratch.
long group_scratch(const GroupView& groups, int lanes);

/// The best this machine can do for blocks of so many lanes (1 or kLanes). GRANARY_SIMD=plain|avx2|avx512 asks for
/// less.
const Operations& operations(int lanes);
/// "avx512", "avx2" or "plain".
const char* instruction_set();

/// Numbers below 1e-308 count as 0 while one of these lives: classes that hold nothing would slow every operation down.
class FlushDenormals {
 public:
  FlushDenormals();
  ~FlushDenormals();
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned before_;
};

}  // namespace granary::pbm::simd
