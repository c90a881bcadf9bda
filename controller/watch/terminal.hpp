// The terminal we draw on: the alternate screen, no cursor, no echo; as it was before whenever we leave it.
// Plain ANSI (ECMA-48 with xterm's alternate screen): a view that only shows needs no terminal library.
#pragma once

#include <termios.h>

#include <string>
#include <vector>

#include "controller/watch/row.hpp"
#include "controller/watch/screen.hpp"

namespace granary::watch {

/// Draws on stdout, reads keys from stdin (if that is a terminal too).
class Terminal {
 public:
  Terminal() { enter(); }
  ~Terminal() { leave(); }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  void enter();  ///< once more after leave(): after a stop by Ctrl-Z
  void leave();
  /// Writes over what is there, with one write and without clearing first: nothing flickers.
  void draw(const std::vector<Row>& rows);
  static ScreenSize size();

 private:
  bool entered_ = false;
  bool keys_ = false;  ///< stdin's settings were changed
  termios before_ = {};
};

bool stdout_is_terminal();  ///< and not a "dumb" one
bool colour_wanted();       ///< a terminal, and no NO_COLOR in the environment
bool unicode_wanted();      ///< as the locale's variables say

}  // namespace granary::watch
