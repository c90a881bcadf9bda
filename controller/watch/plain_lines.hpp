// A campaign as plain lines, for a log file or a pipe: what happened since the last look, and now and then how it
// stands.
#pragma once

#include <string>
#include <vector>

#include "controller/watch/view.hpp"

namespace granary::watch {

class PlainLines {
 public:
  /// `every`: how often a line says how it stands while nothing happens [s].
  explicit PlainLines(double every = 10.0) : every_(every) {}

  /// The lines that the view adds to those before; the last ones once the campaign has ended. `now`: any clock [s].
  std::vector<std::string> lines(const View& view, double now);

 private:
  void tell_happenings(const View& view, std::vector<std::string>& lines);

  double every_;
  bool begun_ = false;
  std::uint64_t told_ = 0;  ///< happenings
  double spoke_ = 0.0;
  std::string headline_;
  std::vector<std::string> warnings_;
};

/// How it stands, in one line.
std::string standing(const View& view);

}  // namespace granary::watch
