#include "pbm_solver/output/state_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <system_error>

#include "common/json/io.hpp"
#include "common/version.hpp"
#include "pbm_solver/model/model_tables.hpp"

namespace granary::pbm {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "granary-pbm-out-1";
constexpr double kFileVersion = 1;
constexpr double kSameTime = 1e-9;    // relative: an output time as a person writes it
constexpr double kSameVolume = 1e-9;  // relative: a pivot of the same grid
constexpr double kRoundOff = 1e-12;   // of the largest value of a row: how far below zero round-off may lead

std::vector<double> pivots(const SolidAxis& axis) {
  std::vector<double> list;
  for (int i = 0; i < axis.size(); ++i) list.push_back(axis.pivot(i));
  return list;
}

Status write_head(Hdf5File& h5, const PbmCase& c, const ClassGrid& grid) {
  GRANARY_CHECK(h5.attribute("/", "format", kFormat));
  GRANARY_CHECK(h5.attribute("/", "version", kFileVersion));
  GRANARY_CHECK(h5.attribute("/", "revision", revision()));
  GRANARY_CHECK(h5.attribute("/", "case", json::dump(to_json(c))));
  for (int solid = 0; solid < 2; ++solid) {
    const std::vector<double> pivot = pivots(grid.axis(solid));
    GRANARY_CHECK(h5.write(fmt::format("/grid/solid_{}", solid + 1), {{pivot.size()}, pivot}, "m^3",
                           fmt::format("volume of solid {} in one particle of each class", solid + 1)));
  }
  return {};
}

Status create_rows(Hdf5File& h5, const PbmCase& c) {
  const auto n1 = static_cast<std::size_t>(c.grid.bins[0]), n2 = static_cast<std::size_t>(c.grid.bins[1]);
  const auto x = static_cast<std::size_t>(c.compartments.count);
  struct Rows {
    const char* name;
    std::vector<std::size_t> shape;
    const char* unit;
    const char* description;
  };
  const Rows all[] = {
      {"/state/time", {}, "s", "process time"},
      {"/state/number", {x, n1, n2}, "1", "particles"},
      {"/state/liquid", {x, n1, n2}, "m^3", "liquid of all particles of the class"},
      {"/state/gas", {x, n1, n2}, "m^3", "gas of all particles of the class"},
      {"/state/next_step", {}, "s", "the step the integrator would take next"},
      {"/state/last_error", {}, "1", "error of its last step over the tolerance"},
      {"/state/ledger",
       {x * ledger::kSize},
       "m^3",
       "by compartment: held at the start, came in, left at the outlet, left above the grid (solid 1, solid 2, liquid, "
       "gas each), "
       "gas consolidated, particles above the grid"},
      {"/state/d10", {x}, "m", "diameter below which 10 % of the particle volume lies"},
      {"/state/d50", {x}, "m", "diameter below which 50 % of the particle volume lies"},
      {"/state/d90", {x}, "m", "diameter below which 90 % of the particle volume lies"},
      {"/state/total_number", {x}, "1", "particles in each compartment"},
      {"/outlet/number_rate", {n1, n2}, "1/s", "particles that leave the last compartment"},
  };
  for (const Rows& r : all) GRANARY_CHECK(h5.create_growing(r.name, r.shape, r.unit, r.description));
  return {};
}

Status append_rows(Hdf5File& h5, const Snapshot& s, const Summary& summary) {
  GRANARY_CHECK(h5.append_row("/state/number", s.number));
  GRANARY_CHECK(h5.append_row("/state/liquid", s.liquid));
  GRANARY_CHECK(h5.append_row("/state/gas", s.gas));
  GRANARY_CHECK(h5.append_row("/state/next_step", {s.next_step}));
  GRANARY_CHECK(h5.append_row("/state/last_error", {s.last_error}));
  GRANARY_CHECK(h5.append_row("/state/ledger", s.ledger));
  GRANARY_CHECK(h5.append_row("/state/d10", summary.d10));
  GRANARY_CHECK(h5.append_row("/state/d50", summary.d50));
  GRANARY_CHECK(h5.append_row("/state/d90", summary.d90));
  GRANARY_CHECK(h5.append_row("/state/total_number", summary.number));
  GRANARY_CHECK(h5.append_row("/outlet/number_rate", summary.outlet_rate));
  // Last: a row is there when its time is.
  GRANARY_CHECK(h5.append_row("/state/time", {s.time}));
  return h5.flush();
}

/// Bytes that may still be written to a file: room on its disk, and what the process is allowed to write.
std::uintmax_t room_in(const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::error_code unknown;
  const fs::space_info disk = fs::space(folder, unknown);
  std::uintmax_t room = unknown ? UINTMAX_MAX : disk.available;
  rlimit allowed{};
  if (getrlimit(RLIMIT_FSIZE, &allowed) == 0 && allowed.rlim_cur != RLIM_INFINITY) {
    const std::uintmax_t written = fs::file_size(file, unknown);
    if (!unknown)
      room = std::min<std::uintmax_t>(room, allowed.rlim_cur - std::min<std::uintmax_t>(allowed.rlim_cur, written));
  }
  return room;
}

/// When a write fails for want of room, HDF5 1.10 ends the process and may leave a file it cannot read again: so look
/// before.
Status room_for(const fs::path& file, const Snapshot& s) {
  const std::uintmax_t row = 8 * (4 * s.number.size() + s.ledger.size()) + 4096;
  constexpr std::uintmax_t kChunks = 256 * 1024;  // chunks and indices are written whole
  const std::uintmax_t needed = 4 * row + kChunks, room = room_in(file);
  if (room >= needed) return {};
  return Error{fmt::format("{}: the disk is full ({} bytes free; the state at {:g} s wants {}). The states before it "
                           "are whole: make room "
                           "and restart from the last of them.",
                           file.string(), room, s.time, needed),
               Exit::task_failed};
}

std::string described(const std::vector<double>& solid_1, const std::vector<double>& solid_2,
                      std::size_t n_compartments) {
  const auto axis = [](const std::vector<double>& p) {
    return p.size() < 2 ? fmt::format("{} class at {:g} m^3", p.size(), p.empty() ? 0.0 : p[0])
                        : fmt::format("{} classes from {:g} m^3 by {:g}", p.size(), p[0], p[1] / p[0]);
  };
  return fmt::format("{} of solid 1, {} of solid 2, {} compartments", axis(solid_1), axis(solid_2), n_compartments);
}

bool same(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
    return std::abs(x - y) <= kSameVolume * std::max(std::abs(x), std::abs(y));
  });
}

/// The times of the rows, finite and rising.
Result<std::vector<double>> read_times(const Hdf5File& h5, const fs::path& file) {
  GRANARY_TRY(DataArray times, h5.read("/state/time"));
  if (times.shape.size() != 1)
    return Error{fmt::format("{}: \"/state/time\" has {} dimensions; a list of times is wanted.", file.string(),
                             times.shape.size())};
  const std::vector<double>& t = times.values;
  for (std::size_t row = 0; row < t.size(); ++row)
    if (!std::isfinite(t[row]) || (row > 0 && t[row] < t[row - 1]))
      return Error{fmt::format("{}: \"/state/time\" has {:g} in row {}; times must be finite and rise.", file.string(),
                               t[row], row)};
  return std::move(times.values);
}

/// Row of the wanted time; the last if none is.
Result<std::size_t> row_of(const std::vector<double>& times, const Restart& restart) {
  if (times.empty()) return Error{fmt::format("{}: it holds no state yet.", restart.file.string())};
  if (!restart.time) return times.size() - 1;
  for (std::size_t t = times.size(); t-- > 0;)
    if (std::abs(times[t] - *restart.time) <= kSameTime * std::max(1.0, std::abs(*restart.time))) return t;
  return Error{fmt::format(
      "{}: there is no state at {:g} s (/restart/time); it has {} from {:g} s to {:g} s. Take one of these, or leave "
      "/restart/time out for the last.",
      restart.file.string(), *restart.time, times.size(), times.front(), times.back())};
}

/// Pivots of one solid, and compartments: what the state in a file is of.
struct Shape {
  std::vector<double> solid_1, solid_2;
  std::size_t n_compartments = 0;
};

Result<Shape> read_shape(const Hdf5File& h5, const fs::path& file) {
  GRANARY_TRY(const std::vector<std::size_t> number, h5.shape("/state/number"));
  if (number.size() != 4)
    return Error{fmt::format("{}: \"/state/number\" has {} dimensions; time, compartment and two solids are wanted.",
                             file.string(), number.size())};
  GRANARY_TRY(DataArray solid_1, h5.read("/grid/solid_1"));
  GRANARY_TRY(DataArray solid_2, h5.read("/grid/solid_2"));
  return Shape{std::move(solid_1.values), std::move(solid_2.values), number[1]};
}

Status check_same_grid(const Shape& has, const PbmCase& c, const ClassGrid& grid, const fs::path& file) {
  const auto wanted_1 = pivots(grid.axis(0)), wanted_2 = pivots(grid.axis(1));
  const auto n_compartments = static_cast<std::size_t>(c.compartments.count);
  if (same(has.solid_1, wanted_1) && same(has.solid_2, wanted_2) && has.n_compartments == n_compartments) return {};
  return Error{
      fmt::format("{}: its state is of another grid: {}; the case has {}. Restart with the grid and the compartments "
                  "of the earlier run.",
                  file.string(), described(has.solid_1, has.solid_2, has.n_compartments),
                  described(wanted_1, wanted_2, n_compartments))};
}

/// Reads rows of one output time, each of the shape its grid asks for.
class RowReader {
 public:
  RowReader(const Hdf5File& h5, const fs::path& file, std::size_t row) : h5_(&h5), file_(&file), row_(row) {}

  /// Finite, and >= `least` times the largest of the row.
  Result<std::vector<double>> operator()(const std::string& name, const std::vector<std::size_t>& row_shape,
                                         double least) const {
    GRANARY_TRY(const std::vector<std::size_t> shape, h5_->shape(name));
    if (shape.empty() || !std::equal(shape.begin() + 1, shape.end(), row_shape.begin(), row_shape.end()))
      return Error{fmt::format("{}: the rows of \"{}\" have the shape ({}); ({}) is wanted. The file is damaged.",
                               file_->string(), name, fmt::join(shape, ", "), fmt::join(row_shape, ", "))};
    GRANARY_TRY(std::vector<double> values, h5_->read_row(name, row_));
    double largest = 0.0;
    for (const double v : values) largest = std::max(largest, v);
    for (std::size_t k = 0; k < values.size(); ++k)
      if (!std::isfinite(values[k]) || values[k] < least * largest)
        return Error{
            fmt::format("{}: \"{}\" has {:g} in row {}, place {}; it must be a finite number{}. "
                        "Restart from another output time.",
                        file_->string(), name, values[k], row_, k, std::isinf(least) ? "" : " >= 0")};
    return values;
  }

 private:
  const Hdf5File* h5_;
  const fs::path* file_;
  std::size_t row_;
};

Result<Snapshot> read_state(const RowReader& read, double time, const std::vector<std::size_t>& shape) {
  constexpr double kAny = -std::numeric_limits<double>::infinity();
  Snapshot s;
  s.time = time;
  GRANARY_TRY(s.number, read("/state/number", shape, -kRoundOff));
  GRANARY_TRY(s.liquid, read("/state/liquid", shape, -kRoundOff));
  GRANARY_TRY(s.gas, read("/state/gas", shape, -kRoundOff));
  GRANARY_TRY(s.ledger, read("/state/ledger", {shape[0] * ledger::kSize}, kAny));
  GRANARY_TRY(const std::vector<double> next_step, read("/state/next_step", {}, 0.0));
  GRANARY_TRY(const std::vector<double> last_error, read("/state/last_error", {}, 0.0));
  s.next_step = next_step[0];
  s.last_error = last_error[0];
  return s;
}

}  // namespace

Result<StateFile> StateFile::create(const fs::path& file, const PbmCase& c, const ClassGrid& grid) {
  GRANARY_TRY(Hdf5File h5, Hdf5File::create_sealed(file));
  GRANARY_CHECK(write_head(h5, c, grid));
  GRANARY_CHECK(create_rows(h5, c));
  GRANARY_CHECK(h5.flush());
  return StateFile(std::move(h5), file);
}

Status StateFile::append(const Snapshot& snapshot, const Summary& summary) {
  GRANARY_CHECK(room_for(file_, snapshot));
  return append_rows(h5_, snapshot, summary);
}

Status write_checkpoint(const fs::path& file, const PbmCase& c, const ClassGrid& grid, const Snapshot& snapshot) {
  fs::path beside = file;
  beside += ".new";
  {
    GRANARY_CHECK(room_for(file, snapshot));
    GRANARY_TRY(StateFile states, StateFile::create(beside, c, grid));
    GRANARY_CHECK(states.append(snapshot, summarize(snapshot, c, grid)));
    // Else a power cut could leave the new name with nothing behind it, and the checkpoint before it gone.
    GRANARY_CHECK(states.h5_.sync());
  }
  std::error_code failed;
  fs::rename(beside, file, failed);
  if (failed) return Error{fmt::format("{}: cannot be put in place: {}.", file.string(), failed.message())};
  return {};
}

Result<Snapshot> read_restart(const Restart& restart, const PbmCase& c, const ClassGrid& grid) {
  GRANARY_TRY(const Hdf5File h5, Hdf5File::open_sealed(restart.file));
  const auto format = h5.text_attribute("/", "format");
  if (!format || *format != kFormat)
    return Error{fmt::format("{}: this is no file of states ({} expected). Restart from an out.h5 or checkpoint.h5.",
                             restart.file.string(), kFormat)};
  GRANARY_TRY(const std::vector<double> times, read_times(h5, restart.file));
  GRANARY_TRY(const std::size_t row, row_of(times, restart));
  GRANARY_TRY(const Shape shape, read_shape(h5, restart.file));
  GRANARY_CHECK(check_same_grid(shape, c, grid, restart.file));
  return read_state(RowReader(h5, restart.file, row), times[row],
                    {shape.n_compartments, shape.solid_1.size(), shape.solid_2.size()});
}

}  // namespace granary::pbm
