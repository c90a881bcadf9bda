// How the state of many compartments lies in memory, so that one instruction serves several of them.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>
#include <vector>

namespace granary::pbm {

/// Memory that starts on a cache line.
template <class T>
struct AlignedAllocator {
  using value_type = T;
  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) {}  // NOLINT: as the standard allocator's
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new (n * sizeof(T), std::align_val_t{64})); }
  void deallocate(T* p, std::size_t) { ::operator delete (p, std::align_val_t{64}); }
  bool operator==(const AlignedAllocator&) const { return true; }
};
using LaneVector = std::vector<double, AlignedAllocator<double>>;

/// Compartments side by side in a block: the lanes of one instruction. Few compartments are taken one by one instead;
/// the lanes are then the moments of a class (N, s1, s2, liquid, gas). The choice depends on the case alone, so that
/// the bits of a result do not depend on ranks or threads: every lane sees the same operations in any block.
inline constexpr int kLanes = 8;
inline constexpr int kOneByOne =
    2;  ///< up to so many compartments are taken one by one: measured, a block costs as much as 2.5
inline int lanes_for(int n_compartments) { return n_compartments <= kOneByOne ? 1 : kLanes; }

/// Moments of a class that births carry: number, solid 1, solid 2, liquid, gas.
inline constexpr int kMoments = 5;
/// Doubles from one class to the next in an array of moments: a multiple of the vector's width.
constexpr int moment_stride(int lanes) { return lanes == 1 ? 8 : kMoments * lanes; }

}  // namespace granary::pbm
