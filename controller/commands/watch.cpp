#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <optional>
#include <thread>

#include "controller/commands/commands.hpp"
#include "controller/commands/watched.hpp"
#include "controller/watch/plain_lines.hpp"
#include "controller/watch/screen.hpp"
#include "controller/watch/terminal.hpp"
#include "pilot/loop/real_loop.hpp"

namespace granary::commands {
namespace fs = std::filesystem;

namespace {

constexpr double kLookPeriod = 0.5;  // [s]

/// The campaign's own exit code; stopped while it has not ended (we were told to leave it).
Exit meaning(const watch::View& view) { return view.exit.value_or(Exit::ok); }

/// Lines on stdout until the campaign has ended.
Exit watch_plain(watch::Watcher& watcher) {
  pilot::RealLoop loop;
  watch::PlainLines plain;
  watch::View view;
  std::function<void()> look = [&] {
    view = watcher.look();
    for (const std::string& line : plain.lines(view, loop.now())) fmt::print("{}\n", line);
    std::fflush(stdout);
    if (view.phase == watch::Phase::ended || std::ferror(stdout) != 0) return loop.stop();
    loop.after(kLookPeriod, look);
  };
  loop.on_signals({SIGINT, SIGTERM, SIGHUP}, [&](int) { loop.stop(); });
  loop.post(look);
  loop.run();
  return meaning(view);
}

/// Draws until the campaign has ended, or the user leaves with Ctrl-C or q; the last picture stays on the terminal.
Exit watch_screen(watch::Watcher& watcher) {
  pilot::RealLoop loop;
  watch::View view;
  const bool unicode = watch::unicode_wanted();
  std::optional<watch::Terminal> terminal(std::in_place);
  const auto draw = [&] { terminal->draw(watch::screen(view, watch::Terminal::size(), unicode)); };
  std::function<void()> look = [&] {
    view = watcher.look();
    draw();
    if (view.phase == watch::Phase::ended) return loop.stop();
    loop.after(kLookPeriod, look);
  };
  loop.on_signals({SIGINT, SIGTERM, SIGHUP}, [&](int) { loop.stop(); });
  loop.on_signals({SIGWINCH}, [&](int) { draw(); });
  loop.on_signals({SIGTSTP}, [&](int) {
    terminal->leave();
    raise(SIGSTOP);
    terminal->enter();
    draw();
  });
  if (isatty(STDIN_FILENO) == 1) {
    loop.watch(
        STDIN_FILENO,
        [&] {
          char key = 0;
          const ssize_t n = ::read(STDIN_FILENO, &key, 1);
          if (n <= 0) return loop.unwatch(STDIN_FILENO);  // nobody types any more
          if (key == 'q' || key == 'Q') loop.stop();
        },
        false);
  }
  loop.post(look);
  loop.run();
  if (isatty(STDIN_FILENO) == 1) loop.unwatch(STDIN_FILENO);
  terminal.reset();
  const watch::ScreenSize size = watch::Terminal::size();
  for (const watch::Row& row : watch::screen(view, {size.columns, size.rows - 1}, unicode))
    fmt::print("{}\n", watch::printed(row, size.columns, watch::colour_wanted()));
  return meaning(view);
}

}  // namespace

Result<Exit> watch(const fs::path& dir) {
  GRANARY_TRY(watch::Watcher watcher, watcher_of(dir));
  return watch::stdout_is_terminal() ? watch_screen(watcher) : watch_plain(watcher);
}

}  // namespace granary::commands
