#include "pilot/launch/set_aside.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <optional>
#include <set>
#include <string>

namespace granary::pilot {

namespace fs = std::filesystem;

fs::path stdout_path(const Launch& launch) {
  return launch.dir / (launch.spec.stdout_file.empty() ? fs::path(launch.spec.name + ".out") : launch.spec.stdout_file);
}

fs::path stderr_path(const Launch& launch) {
  return launch.spec.stderr_file.empty() ? stdout_path(launch) : launch.dir / launch.spec.stderr_file;
}

namespace {

using Stamp = std::pair<std::int64_t, std::uint32_t>;  ///< seconds and nanoseconds

/// When the file was made, on the clock that stamps its neighbours' changes. Nothing if the file system does not know.
std::optional<Stamp> birth_of(const fs::path& file) {
  struct statx status = {};
  if (statx(AT_FDCWD, file.c_str(), AT_SYMLINK_NOFOLLOW, STATX_BTIME, &status) != 0) return std::nullopt;
  if ((status.stx_mask & STATX_BTIME) == 0) return std::nullopt;
  return Stamp{status.stx_btime.tv_sec, status.stx_btime.tv_nsec};
}

std::optional<Stamp> change_of(const fs::path& file) {
  struct statx status = {};
  if (statx(AT_FDCWD, file.c_str(), AT_SYMLINK_NOFOLLOW, STATX_MTIME, &status) != 0) return std::nullopt;
  return Stamp{status.stx_mtime.tv_sec, status.stx_mtime.tv_nsec};
}

}  // namespace

Status set_aside_attempt(const Launch& earlier, bool own_folder) {
  const fs::path keep = earlier.dir / fmt::format("{}.attempt-{}", earlier.spec.name, earlier.attempt.number);
  std::set<fs::path> files{stdout_path(earlier), stderr_path(earlier)};
  for (const fs::path& file : earlier.spec.produces) files.insert(earlier.dir / file);
  std::error_code error;
  // The output file is the first thing an attempt makes: what is younger was written by it.
  if (const auto started = own_folder ? birth_of(stdout_path(earlier)) : std::nullopt) {
    const std::string kept_before = earlier.spec.name + ".attempt-";
    for (const auto& entry : fs::directory_iterator(earlier.dir, error)) {
      const auto changed = change_of(entry.path());
      if (changed && *changed > *started && !entry.path().filename().string().starts_with(kept_before))
        files.insert(entry.path());
    }
  }
  for (const fs::path& file : files) {
    // Only what an attempt can have made: /dev/null may be its output, but is not to be moved.
    const fs::file_type type = fs::symlink_status(file, error).type();
    if (type != fs::file_type::regular && type != fs::file_type::directory && type != fs::file_type::symlink) continue;
    fs::path inside = file.lexically_relative(earlier.dir);
    if (inside.empty() || *inside.begin() == "..") inside = file.filename();
    const fs::path target = keep / inside;
    fs::create_directories(target.parent_path(), error);
    if (!error) fs::rename(file, target, error);
    if (error) {
      return Error{fmt::format("{}: cannot be kept as {} before the next attempt: {}", file.string(), target.string(),
                               error.message()),
                   Exit::task_failed};
    }
  }
  return {};
}

}  // namespace granary::pilot
