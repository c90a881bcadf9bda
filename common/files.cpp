#include "common/files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>

namespace granary {
namespace fs = std::filesystem;
namespace {

Error write_error(const fs::path& file, int code) {
  const char* advice = code == ENOSPC || code == EDQUOT ? " Free some space, then resume." : "";
  return {fmt::format("{}: cannot be written: {}.{}", file.string(), std::strerror(code), advice), Exit::task_failed};
}

/// Writes all bytes or gives errno.
int write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(fd, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  return 0;
}

}  // namespace

Result<std::string> read_text(const fs::path& file) {
  std::error_code ignored;
  if (fs::is_directory(file, ignored)) return Error{file.string() + ": is a folder; a file is wanted."};
  std::ifstream in(file, std::ios::binary);
  if (!in) return Error{fmt::format("{}: cannot be read: {}.", file.string(), std::strerror(errno))};
  std::ostringstream text;
  text << in.rdbuf();
  if (in.bad()) return Error{fmt::format("{}: cannot be read to its end: {}.", file.string(), std::strerror(errno))};
  return std::move(text).str();
}

Status write_text_atomically(const fs::path& file, std::string_view text) {
  const fs::path beside = file.string() + ".new";
  const int fd = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return write_error(file, errno);
  int code = write_all(fd, text);
  if (code == 0 && ::fsync(fd) != 0) code = errno;
  if (::close(fd) != 0 && code == 0) code = errno;
  if (code == 0 && ::rename(beside.c_str(), file.c_str()) != 0) code = errno;
  if (code == 0) return {};
  ::unlink(beside.c_str());
  return write_error(file, code);
}

Status make_folders(const fs::path& folder) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) return Error{fmt::format("{}: cannot be made: {}.", folder.string(), code.message()), Exit::task_failed};
  return {};
}

fs::path program_folder() {
  std::error_code ignored;
  return fs::read_symlink("/proc/self/exe", ignored).parent_path();
}

std::string fingerprint(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return fmt::format("{:016x}", hash);
}

}  // namespace granary
