#define GRANARY_SIMD_SET avx2
#include "pbm_solver/model/simd/operations.inc"
