// Measured data from files: columns of numbers with units, from CSV or HDF5, in SI. Formats: docs/workflow_format.md.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace granary::campaign {

/// A column that may be there: its name, and the SI unit its values are wanted in. "%" stands beside any unit.
struct WantedColumn {
  std::string name, si_unit;
  bool percent = false;  ///< "%" is allowed too: of another column
};

struct Column {
  std::vector<double> values;  ///< NaN: an empty cell
  bool percent = false;        ///< in shares of 1 of another column's value
};

using Table = std::map<std::string, Column>;

/// CSV: separated by commas, semicolons or tabs; "#" begins a comment line; the first line names the columns, with
/// their units in brackets: `time [s],d50 [um],error [%]`. Errors: no such file, an unknown column (lists those there
/// may be), a unit that is missing or of another kind, a cell that is no number (names the line), columns of unequal
/// length.
Result<Table> read_csv(const std::filesystem::path& file, const std::vector<WantedColumn>& wanted);

/// A dataset of HDF5 with the attribute "unit", row-major, in SI. results.h5 has such datasets.
struct Dataset {
  std::vector<std::size_t> shape;
  std::vector<double> values;
};
Result<Dataset> read_dataset(const std::filesystem::path& file, const std::string& name, const std::string& si_unit);
bool has_dataset(const std::filesystem::path& file, const std::string& name);

}  // namespace granary::campaign
