// Wall time of what a bench measures.
#pragma once

#include <chrono>

namespace granary::bench {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

}  // namespace granary::bench
