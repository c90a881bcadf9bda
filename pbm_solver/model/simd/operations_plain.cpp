#define GRANARY_SIMD_SET plain
#include "pbm_solver/model/simd/operations.inc"
