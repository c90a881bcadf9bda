// How the pictures of the benches look.
#pragma once

#include <fmt/format.h>

#include <string>

namespace granary::bench {

/// gnuplot commands for an SVG of this size [px]: paper, letters, axes.
inline std::string plot_style(int width, int height, int letters) {
  return fmt::format(
      "set encoding utf8\n"
      "set terminal svg noenhanced size {},{} dynamic font 'system-ui,sans-serif,{}' background '#ffffff'\n"
      "set border 3 lc rgb '#94a3b8' lw 1\n"
      "set tics out nomirror scale 0.5 textcolor rgb '#334155'\n",
      width, height, letters);
}

}  // namespace granary::bench
