// How long a neighbour list lasts where the bed turns with its impeller. Plain numbers: no LIGGGHTS.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace granary::dem {

/// A list of all pairs nearer than their radii and a skin is complete as long as no particle has moved by half the skin
/// since it was made. It need not be the laboratory in which it moves: a frame that turns leaves all distances between
/// particles as they are, so by the same argument
///
///   |x_i(t) - Q(t) x_i(0)| < skin / 2 for all i,     Q any rotation, the same for all,
///
/// is enough. Particles that fly with a blade and others that stand are then equally slow in a frame between them.
/// Checked against all pairs in turning_frame_test.cpp.
class TurningFrame {
 public:
  /// It turns about the coordinate axis x, y or z: 0, 1, 2.
  explicit TurningFrame(int axis) : a_(axis), b_((axis + 1) % 3), c_((axis + 2) % 3) {}

  /// The list is made now. places: x y z of each particle [m].
  void start(const double* places, std::size_t n);
  /// How far the one of the n particles (as many, in the same order) that has moved farthest in the frame has [m]. The
  /// frame has turned by `angle` since then [rad]. Infinite where a place is no number, or there are more or fewer.
  double farthest_moved(const double* places, std::size_t n, double angle) const;

  /// Squares of the largest speed that a particle has now in a frame turning at each of the rates [m^2/s^2].
  std::vector<double> largest_speeds2(const double* places, const double* velocities, std::size_t n,
                                      std::span<const double> rates) const;

 private:
  std::size_t a_, b_, c_;                   ///< the axis and the two others, right-handed
  std::vector<double> at_a_, at_b_, at_c_;  ///< places when the list was made
};

}  // namespace granary::dem
