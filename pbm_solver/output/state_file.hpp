// out.h5 and checkpoint.h5: states over time, and starting again from one (docs/exchange_formats.md).
#pragma once

#include <filesystem>

#include "common/result.hpp"
#include "common/results/hdf5_file.hpp"
#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/model/class_grid.hpp"
#include "pbm_solver/output/summary.hpp"
#include "pbm_solver/time/snapshot.hpp"

namespace granary::pbm {

/// A file of states that grows by a row at each output. Sealed: what has been appended stays readable whatever happens
/// later, and a row is there as a whole or not at all.
class StateFile {
 public:
  static Result<StateFile> create(const std::filesystem::path& file, const PbmCase& pbm_case, const ClassGrid& grid);
  /// Errors: the disk is full (said before anything is written, so that the rows before stay whole) or refuses.
  Status append(const Snapshot& snapshot, const Summary& summary);

 private:
  friend Status write_checkpoint(const std::filesystem::path&, const PbmCase&, const ClassGrid&, const Snapshot&);
  StateFile(Hdf5File h5, std::filesystem::path file) : h5_(std::move(h5)), file_(std::move(file)) {}
  Hdf5File h5_;
  std::filesystem::path file_;
};

/// One state in a file of its own, written beside `file` and renamed over it.
Status write_checkpoint(const std::filesystem::path& file, const PbmCase& pbm_case, const ClassGrid& grid,
                        const Snapshot& snapshot);

/// The state a case restarts from: finite, and not negative beyond round-off. Errors: no such file, one without a seal
/// or damaged (before HDF5 sees it), another grid or number of compartments (both are named), no output at that time
/// (the times there are are named), a value that no state can have (file, dataset, row and value are named).
Result<Snapshot> read_restart(const Restart& restart, const PbmCase& pbm_case, const ClassGrid& grid);

}  // namespace granary::pbm
