#include "controller/watch/terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <string_view>

namespace granary::watch {

namespace {

constexpr std::string_view kEnter = "\033[?1049h\033[?25l\033[?7l\033[2J";  // alternate screen, no cursor, no wrapping
constexpr std::string_view kLeave = "\033[?7h\033[?25h\033[?1049l";

void write_all(std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = write(STDOUT_FILENO, text.data(), text.size());
    if (n < 0 && errno != EINTR) return;  // a terminal that has gone away: the signal tells
    if (n > 0) text.remove_prefix(static_cast<std::size_t>(n));
  }
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

}  // namespace

void Terminal::enter() {
  if (entered_) return;
  entered_ = true;
  keys_ = tcgetattr(STDIN_FILENO, &before_) == 0;
  if (keys_) {
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);  // keys come at once and leave no trace; Ctrl-C stays one
    raw.c_cc[VMIN] = 0;
    raw.c_cc[VTIME] = 0;
    tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  }
  write_all(kEnter);
}

void Terminal::leave() {
  if (!entered_) return;
  entered_ = false;
  write_all(kLeave);
  if (keys_) tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

void Terminal::draw(const std::vector<Row>& rows) {
  const ScreenSize space = size();
  std::string frame = "\033[H";
  for (std::size_t r = 0; r < rows.size() && r < static_cast<std::size_t>(space.rows); ++r) {
    if (r > 0) frame += "\r\n";
    frame += printed(rows[r], space.columns, colour_wanted()) + "\033[K";
  }
  write_all(frame + "\033[J");
}

ScreenSize Terminal::size() {
  winsize window = {};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) != 0 || window.ws_col == 0 || window.ws_row == 0) return {};
  return {window.ws_col, window.ws_row};
}

bool stdout_is_terminal() { return isatty(STDOUT_FILENO) == 1 && environment("TERM") != "dumb"; }
bool colour_wanted() { return stdout_is_terminal() && environment("NO_COLOR").empty(); }

bool unicode_wanted() {
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    const std::string locale = environment(name);
    if (locale.empty()) continue;
    return locale.find("UTF-8") != std::string::npos || locale.find("utf8") != std::string::npos;
  }
  return false;
}

}  // namespace granary::watch
