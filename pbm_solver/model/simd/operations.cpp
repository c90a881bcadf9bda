#include "pbm_solver/model/simd/operations.hpp"

#include <cstdlib>
#include <string>

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace granary::pbm::simd {

// Each set is a translation unit with its own compiler flags.
#define GRANARY_DECLARE_SET(name)     \
  namespace name {                    \
  extern const Operations one_by_one; \
  extern const Operations by_lanes;   \
  }
GRANARY_DECLARE_SET(plain)
#if defined(__x86_64__)
GRANARY_DECLARE_SET(avx2)
GRANARY_DECLARE_SET(avx512)
#endif

namespace {

enum class Set { plain, avx2, avx512 };

Set choose_set() {
#if defined(__x86_64__)
  const char* asked = std::getenv("GRANARY_SIMD");
  const std::string most = asked != nullptr ? asked : "";
  const bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                    __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
                    __builtin_cpu_supports("avx512cd");
  if (wide && most != "avx2" && most != "plain") return Set::avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && most != "plain") return Set::avx2;
#endif
  return Set::plain;
}

Set chosen() {
  static const Set set = choose_set();
  return set;
}

}  // namespace

const Operations& operations(int lanes) {
  switch (chosen()) {
#if defined(__x86_64__)
    case Set::avx512:
      return lanes == 1 ? avx512::one_by_one : avx512::by_lanes;
    case Set::avx2:
      return lanes == 1 ? avx2::one_by_one : avx2::by_lanes;
#endif
    default:
      return lanes == 1 ? plain::one_by_one : plain::by_lanes;
  }
}

const char* instruction_set() {
  switch (chosen()) {
    case Set::avx512:
      return "avx512";
    case Set::avx2:
      return "avx2";
    default:
      return "plain";
  }
}

long group_scratch(const GroupView& groups, int lanes) {
  return static_cast<long>(groups.n_groups) * (3 + groups.n_tops_2 + 2 * groups.n_tops_1 * groups.n_tops_2) * lanes;
}

#if defined(__x86_64__)
FlushDenormals::FlushDenormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040u); }
FlushDenormals::~FlushDenormals() { _mm_setcsr(before_); }
#else
FlushDenormals::FlushDenormals() : before_(0) {}
FlushDenormals::~FlushDenormals() = default;
#endif

}  // namespace granary::pbm::simd
