#include "dem_templates/plugin/state_file.hpp"

#include <fcntl.h>
#include <input.h>
#include <lammps.h>
#include <mpi.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <vector>

namespace granary::dem {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

Error cannot_write(const std::string& file) {
  const int why = errno;
  return Error{"the state cannot be written to " + file + ": " + std::strerror(why) +
                   (why == ENOSPC || why == EDQUOT ? ". Free some space, then resume from the state before." : "."),
               Exit::task_failed};
}

// From its start to its end, flushed to disk.
Status copy_to_file(int memory, const std::string& file) {
  const Descriptor out(open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (out.get() < 0 || lseek(memory, 0, SEEK_SET) < 0) return cannot_write(file);
  std::vector<char> buffer(1 << 20);
  for (;;) {
    const ssize_t n = read(memory, buffer.data(), buffer.size());
    if (n < 0) return cannot_write(file);
    if (n == 0) break;
    for (ssize_t done = 0; done < n;) {
      const ssize_t written = write(out.get(), buffer.data() + done, static_cast<std::size_t>(n - done));
      if (written < 0 && errno != EINTR) return cannot_write(file);
      if (written > 0) done += written;
    }
  }
  return fsync(out.get()) == 0 || errno == EINVAL ? Status{} : cannot_write(file);
}

}  // namespace

Status write_state(LAMMPS_NS::LAMMPS& lammps, const std::string& file) {
  const Descriptor memory(memfd_create("granary-state", MFD_CLOEXEC));
  lammps.input->one(("write_restart /proc/self/fd/" + std::to_string(memory.get())).c_str());

  int rank = 0;
  MPI_Comm_rank(lammps.world, &rank);
  if (rank != 0) return {};
  const std::string unfinished = file + ".part";
  const Status copied = copy_to_file(memory.get(), unfinished);
  if (!copied) {
    unlink(unfinished.c_str());
    return copied;
  }
  return std::rename(unfinished.c_str(), file.c_str()) == 0 ? Status{} : cannot_write(file);
}

}  // namespace granary::dem
