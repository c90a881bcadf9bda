// A View as rows of a terminal of a given size. Pure: the same view gives the same rows.
#pragma once

#include <vector>

#include "controller/watch/row.hpp"
#include "controller/watch/view.hpp"

namespace granary::watch {

struct ScreenSize {
  int columns = 80, rows = 24;
};

/// At most size.rows rows; what matters least (older events, the chart's height) gives way on a small terminal.
std::vector<Row> screen(const View& view, ScreenSize size, bool unicode);

}  // namespace granary::watch
