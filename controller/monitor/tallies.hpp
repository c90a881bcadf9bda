// tallies.jsonl of a DEM burst as numbers, each line held against the header. Format: docs/exchange_formats.md.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::monitor {

inline constexpr double kInstant = 1e-9;  ///< slack for times that are sums of windows [s]

struct TallyHeader {
  std::vector<double> class_edge;        ///< DEM diameters [m], shape (n_classes + 1)
  std::vector<double> compartment_edge;  ///< along the axis [m], shape (n_compartments + 1)
  std::vector<std::string> bodies;
  double window = 0.0;           ///< [s]
  double coarse_graining = 1.0;  ///< DEM diameter / real diameter

  std::size_t n_classes() const { return class_edge.size() - 1; }
  std::size_t n_compartments() const { return compartment_edge.size() - 1; }
};

/// Relative normal speeds at first touch: how many, and mean and variance of ln(U / (m/s)).
struct SpeedMoments {
  double count = 0.0;
  double ln_mean = 0.0;
  double ln_variance = 0.0;
};

struct TallyWindow {
  double time = 0.0;                           ///< end of the window [s]
  double window = 0.0;                         ///< its length [s]
  std::vector<std::vector<double>> particles;  ///< shape (n_compartments, n_classes)
  std::vector<std::vector<double>>
      collisions;  ///< new contacts, symmetric, unordered pairs; shape (n_classes, n_classes)
  std::vector<double> collisions_by_compartment;  ///< shape (n_compartments)
  std::vector<double> impacts;                    ///< with all bodies, shape (n_classes)
  SpeedMoments collision_speed, impact_speed;
  std::vector<double> speed_mean, speed_rms;  ///< [m/s], shape (n_classes)

  double total_collisions() const;  ///< sum over p <= q
  double total_impacts() const;
  std::vector<double> particles_by_class() const;  ///< summed over compartments, shape (n_classes)
  double total_particles() const;
};

/// What the program says when its run has diverged.
struct Divergence {
  std::string cause, message;
  double time = 0.0;
  json::Value record;
};

/// Errors name `place` ("tallies.jsonl:12"), the member, and what it must be.
Result<TallyHeader> read_tally_header(const json::Value& line, const std::string& place);
Result<TallyWindow> read_tally_window(const json::Value& line, const TallyHeader& header, const std::string& place);
/// Empty if the line is not about a divergence.
std::optional<Divergence> read_divergence(const json::Value& line);

/// A whole file: header and windows.
struct Tallies {
  TallyHeader header;
  std::vector<TallyWindow> windows;
  std::optional<Divergence> diverged;
};
/// @param lines  every line of the file, the header first.   @param file  opens the messages.
Result<Tallies> read_tallies(const std::vector<json::Value>& lines, const std::string& file);

}  // namespace granary::monitor
