// What draws the plots of a page. The real one is gnuplot (gnuplot.hpp); tests have their own.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"

namespace granary::report {

/// One picture as the plotter needs it.
struct Plot {
  std::string id;      ///< unique on the page, letters and digits and '-': "d50"
  int width = 760;     ///< [px]
  int height = 380;    ///< [px]
  std::string script;  ///< gnuplot commands with their data; no terminal, no output
};

class Plotter {
 public:
  virtual ~Plotter() = default;
  /// One <svg> element for each plot, in the same order; ids inside are unique on the page.
  virtual Result<std::vector<std::string>> draw(const std::vector<Plot>& plots) = 0;
};

}  // namespace granary::report
