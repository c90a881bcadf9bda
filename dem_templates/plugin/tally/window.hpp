// What is counted between two lines of tallies.jsonl, and the lines themselves (docs/exchange_formats.md).
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/json/value.hpp"

namespace granary::dem {

/// The bins everything is counted in; lists of edges ascend.
struct TallyLayout {
  std::vector<double> class_edges;        ///< particle diameters [m], n_classes + 1
  std::vector<double> compartment_edges;  ///< along the axis [m], n_compartments + 1
  std::vector<double> speed_edges;        ///< [m/s], n_speeds + 1
  std::vector<std::string> bodies;
  int axis = 0;  ///< 0, 1, 2: x, y, z

  std::size_t n_classes() const { return class_edges.size() - 1; }
  std::size_t n_compartments() const { return compartment_edges.size() - 1; }
  std::size_t n_speeds() const { return speed_edges.size() - 1; }
};

/// H + 1 edges evenly spaced in the logarithm.
std::vector<double> log_spaced(double lowest, double highest, std::size_t bins);

/// The bin of x; below the first edge it is the first bin, above the last edge the last.
std::size_t bin_of(std::span<const double> edges, double x);

/// What a run tells about itself in the header line.
struct TallyHeader {
  double time_step = 0.0;  ///< [s]
  double window = 0.0;     ///< [s]
  double coarse_graining = 1.0;
  int ranks = 1;
  long start_step = 0;
  long seed = 0;
};
json::Value header_line(const TallyLayout& layout, const TallyHeader& header);

/// When a window ended, and the balance of particles over it; the same on all ranks.
struct WindowEnd {
  double time = 0.0;  ///< DEM clock [s]
  long step = 0;
  double length = 0.0;  ///< [s]
  long inserted = 0, left = 0, lost = 0;
};

/// What particles do to a body.
struct BodyLoad {
  std::array<double, 3> force{};   ///< [N]
  std::array<double, 3> torque{};  ///< about the origin of its axis [N m]
  double axial_torque = 0.0;       ///< about its axis [N m]
  double power = 0.0;              ///< that the body gives to the particles [W]
};

/// The sums of one rank over one window. Add up sums() and take the maximum of maxima() over the ranks, then print.
class Window {
 public:
  /// `layout` must outlive the window.
  explicit Window(const TallyLayout& layout);

  /// A contact between two particles began. Diameters [m], midpoint along the axis [m], normal speed [m/s].
  void collision(double diameter_a, double diameter_b, double axial, double speed);
  void impact(std::size_t body, double diameter, double axial, double speed);
  /// A particle as it is at a survey; speed_squared [m^2/s^2], axial velocity [m/s], mass [kg].
  void particle(double diameter, double axial, double axial_velocity, double speed_squared, double mass);
  /// A particle went from one place along the axis to another since the last survey.
  void moved(double axial_before, double axial_now);
  void overlap(double fraction) {
    if (fraction > maxima_[0]) maxima_[0] = fraction;
  }
  void survey_done() { ++surveys_; }
  /// The load of a body at a look; bodies that are never given one have none in the line.
  void load(std::size_t body, const BodyLoad& load);
  void loads_done() { ++load_looks_; }

  double largest_overlap() const { return maxima_[0]; }
  std::span<double> sums() { return sums_; }
  std::span<double> maxima() { return maxima_; }

  json::Value line(const WindowEnd& end) const;
  void clear();

 private:
  struct SpeedSums {  ///< where count, sum, sum of ln, sum of ln^2 and the histogram lie in sums_
    std::size_t at;
  };
  void add_speed(SpeedSums where, double speed);
  json::Value speed_summary(SpeedSums where) const;
  json::Value loads() const;
  std::span<const double> part(std::size_t at, std::size_t n) const { return std::span(sums_).subspan(at, n); }

  const TallyLayout& layout_;
  std::size_t particles_, solid_volume_, axial_velocity_, collisions_, collisions_by_compartment_, impacts_,
      impacts_by_compartment_, speed_, speed_squared_, axial_flux_, kinetic_energy_, loads_;  ///< places in sums_
  SpeedSums collision_speed_, impact_speed_;
  std::vector<double> sums_;
  std::vector<double> maxima_;
  std::vector<bool> loaded_;  ///< of each body: was given a load
  long surveys_ = 0, load_looks_ = 0;
};

}  // namespace granary::dem
