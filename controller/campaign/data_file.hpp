// Measured data from files: columns of numbers with units, from CSV or HDF5, in SI. Formats: docs/workflow_format.md.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace granary::campaign {

struct Column {
  std::vector<double> values;  ///< NaN: an empty cell
  bool percent = false;        ///< in shares of 1 of another column's value
};

/// CSV: separated by commas, semicolons or tabs; "#" begins a comment line; the first line names the columns, with
/// their units in brackets: `time [s],d50 [um],d50_error [%],sample`. Columns nobody asks for may hold anything.
class CsvFile {
 public:
  /// Errors: no such file, none but comments in it, a line of another number of cells, a column that is there twice.
  static Result<CsvFile> read(const std::filesystem::path& file);

  bool has(const std::string& column) const { return find(column) != nullptr; }
  /// In SI. Errors: no such column (lists those there are), a unit that is missing or of another kind, a cell that is
  /// no number (names the line). "%" is allowed beside any unit where `percent`: of another column.
  Result<Column> column(const std::string& name, const std::string& si_unit, bool percent = false) const;

 private:
  struct Heading {
    std::string name, unit;  ///< unit "": there is none
    std::size_t at;
  };
  struct Row {
    std::size_t line;
    std::vector<std::string> cells;
  };
  const Heading* find(const std::string& name) const;
  Status read_headings(const std::vector<std::string>& cells);
  Error no_column(const std::string& name) const;

  std::string file_;
  std::vector<Heading> headings_;
  std::vector<Row> rows_;
};

/// A dataset of HDF5 with the attribute "unit", row-major, in SI. results.h5 has such datasets.
struct Dataset {
  std::vector<std::size_t> shape;
  std::vector<double> values;
};
Result<Dataset> read_dataset(const std::filesystem::path& file, const std::string& name, const std::string& si_unit);
bool has_dataset(const std::filesystem::path& file, const std::string& name);

}  // namespace granary::campaign
