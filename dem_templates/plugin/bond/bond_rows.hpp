// All bonds of a rank between two neighbour lists, laid out so that the processor works on several at once.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "dem_templates/plugin/bond/bond_law.hpp"

namespace granary::dem {

class BondRows {
 public:
  /// Bonds are advanced this many at a time: what goes in and comes out stays in the fastest memory.
  static constexpr std::size_t kBlock = 128;

  struct Block {
    /// Of BondMotion, number by number; what lies beyond the last bond may be anything but a distance of 0.
    std::array<std::array<double, kBlock>, 12> motion;
    /// Of BondLoad: force, torque, far_torque.
    std::array<std::array<double, kBlock>, 9> load;
    std::array<double, kBlock> tension;   ///< [N]
    std::array<double, kBlock> overload;  ///< bond_overload()
    Block();
  };

  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  void add(const Bond& bond, const BondSection& section);
  /// The last row takes the place of row k.
  void remove(std::size_t k);
  /// Sets the state of a bond to that of row k.
  void copy_state(std::size_t k, Bond& bond) const;
  BondSection section(std::size_t k) const;

  /// bond_load() and bond_overload() of the rows from `first` on, kBlock or what is left. How many.
  std::size_t advance(const BondMaterial& material, double time_step, bool frozen, std::size_t first, Block& block);

 private:
  static constexpr std::size_t kState = 10, kFixed = 13, kColumns = kState + kFixed;
  double* column(std::size_t c) { return numbers_.data() + c * room_; }
  const double* column(std::size_t c) const { return numbers_.data() + c * room_; }
  void make_room();

  std::size_t size_ = 0, room_ = 0;
  std::vector<double> numbers_;  ///< column after column, each of room_ numbers
};

}  // namespace granary::dem
