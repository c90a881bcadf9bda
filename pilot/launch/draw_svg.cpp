#include "pilot/launch/draw_svg.hpp"

#include <fmt/format.h>

#include "common/files.hpp"
#include "pilot/launch/run_program.hpp"

namespace granary::pilot {
namespace {

constexpr double kTimeout = 60.0;  // [s]; it takes a fraction of a second

}  // namespace

Status draw_svg(const std::string& script, const std::filesystem::path& file) {
  const auto drawn = run_program({"gnuplot", "-"}, script, kTimeout);
  if (!drawn)
    return Error{
        fmt::format("{} The plot is drawn by gnuplot (Debian: apt-get install gnuplot-nox).", drawn.error().message),
        Exit::task_failed};
  if (drawn->exit_code != 0 || drawn->out.find("</svg>") == std::string::npos)
    return Error{fmt::format("gnuplot ended with exit code {} (signal {}): {}", drawn->exit_code, drawn->signal,
                             drawn->err.substr(0, 2000)),
                 Exit::internal};
  return write_text_atomically(file, drawn->out);
}

}  // namespace granary::pilot
