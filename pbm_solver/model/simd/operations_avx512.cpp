#define GRANARY_SIMD_SET avx512
#include "pbm_solver/model/simd/operations.inc"
