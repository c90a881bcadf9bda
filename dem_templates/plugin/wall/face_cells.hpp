// A grid of cells over a set of faces: which of them are near a point, nearest first, and how far off they are at
// least. Built once, asked millions of times.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "dem_templates/plugin/wall/face.hpp"
#include "dem_templates/plugin/wall/nearby.hpp"

namespace granary::dem {

class FaceCells {
 public:
  /// What a point's cell knows. A face keeps at least `distance - off_middle` from the point.
  struct Near {
    double clear = 0.0;                 ///< distance from the point to any face that is not listed, at least [m]
    double off_middle = 0.0;            ///< of the point from the cell's middle [m]
    std::span<const NearPart> entries;  ///< with distances from the middle, the nearest first
  };

  FaceCells() = default;
  /// reach: all faces nearer than this to a point are listed in its cell [m].
  FaceCells(std::span<const Face> faces, double reach);

  Near near(const Vector3& point) const;
  /// It will be asked for soon.
  void fetch(const Vector3& point) const;

 private:
  struct Cell {
    float clear;          ///< of the middle, from whatever is not listed [m]
    std::uint32_t first;  ///< of its entries; they end where those of the next cell begin
  };

  /// Calls with_cell(number, middle) for the cells that a face's box, widened, meets.
  template <class WithCell>
  void for_cells_near(const Face& face, double widened, WithCell&& with_cell) const;
  void list(std::span<const Face> faces, double reach);
  void measure_empty_cells();
  bool inside(const Vector3& point) const;
  std::array<long, 3> cell_of(const Vector3& point) const;
  Vector3 middle(long i, long j, long k) const;
  std::size_t index(long i, long j, long k) const {
    return static_cast<std::size_t>((i * n_cells_[1] + j) * n_cells_[2] + k);
  }

  Vector3 low_{}, high_{};  ///< of the cells
  double margin_ = 0.0;     ///< between them and the faces [m]
  double cell_size_ = 1.0;
  std::array<long, 3> n_cells_{};
  std::vector<Cell> cells_;  ///< and one more, for its `first`
  std::vector<NearPart> entries_;
};

}  // namespace granary::dem
