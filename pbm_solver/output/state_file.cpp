#include "pbm_solver/output/state_file.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <system_error>

#include "common/json/io.hpp"
#include "common/version.hpp"
#include "pbm_solver/model/compartment.hpp"

namespace granary::pbm {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "granary-pbm-out-1";
constexpr double kFileVersion = 1;
constexpr double kSameTime = 1e-9;    // relative: an output time as a person writes it
constexpr double kSameVolume = 1e-9;  // relative: a pivot of the same grid

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

}  // namespace

Result<StateFile> StateFile::create(const fs::path& file, const PbmCase& c, const ClassGrid& grid) {
  GRANARY_TRY(Hdf5File h5, Hdf5File::create(file));
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
  }
  std::error_code failed;
  fs::rename(beside, file, failed);
  if (failed) return Error{fmt::format("{}: cannot be put in place: {}.", file.string(), failed.message())};
  return {};
}

Result<Snapshot> read_restart(const Restart& restart, const PbmCase& c, const ClassGrid& grid) {
  GRANARY_TRY(const Hdf5File h5, Hdf5File::open(restart.file));
  const auto format = h5.text_attribute("/", "format");
  if (!format || *format != kFormat)
    return Error{fmt::format("{}: this is no file of states ({} expected). Restart from an out.h5 or checkpoint.h5.",
                             restart.file.string(), kFormat)};
  GRANARY_TRY(const DataArray solid_1, h5.read("/grid/solid_1"));
  GRANARY_TRY(const DataArray solid_2, h5.read("/grid/solid_2"));
  GRANARY_TRY(const DataArray times, h5.read("/state/time"));
  GRANARY_TRY(const std::size_t row, row_of(times.values, restart));
  Snapshot s;
  s.time = times.values[row];
  GRANARY_TRY(const std::vector<double> total, h5.read_row("/state/total_number", row));
  const auto wanted_1 = pivots(grid.axis(0)), wanted_2 = pivots(grid.axis(1));
  const auto n_compartments = static_cast<std::size_t>(c.compartments.count);
  if (!same(solid_1.values, wanted_1) || !same(solid_2.values, wanted_2) || total.size() != n_compartments)
    return Error{fmt::format(
        "{}: its state is of another grid: {}; the case has {}. Restart with the grid and the compartments of the "
        "earlier run.",
        restart.file.string(), described(solid_1.values, solid_2.values, total.size()),
        described(wanted_1, wanted_2, n_compartments))};
  GRANARY_TRY(s.number, h5.read_row("/state/number", row));
  GRANARY_TRY(s.liquid, h5.read_row("/state/liquid", row));
  GRANARY_TRY(s.gas, h5.read_row("/state/gas", row));
  GRANARY_TRY(s.ledger, h5.read_row("/state/ledger", row));
  GRANARY_TRY(const std::vector<double> next_step, h5.read_row("/state/next_step", row));
  GRANARY_TRY(const std::vector<double> last_error, h5.read_row("/state/last_error", row));
  s.next_step = next_step.at(0);
  s.last_error = last_error.at(0);
  if (s.number.size() != n_compartments * grid.size() || s.ledger.size() != n_compartments * ledger::kSize)
    return Error{
        fmt::format("{}: its rows are not as long as its grid asks. The file is damaged.", restart.file.string())};
  return s;
}

}  // namespace granary::pbm
