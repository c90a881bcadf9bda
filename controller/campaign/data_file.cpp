#include "controller/campaign/data_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>
#include <sstream>

#include "common/files.hpp"
#include "common/results/hdf5_file.hpp"
#include "common/units.hpp"

namespace granary::campaign {
namespace fs = std::filesystem;

namespace {

std::string trimmed(const std::string& text) {
  const auto blank = [](unsigned char c) { return std::isspace(c) != 0; };
  const auto first = std::find_if_not(text.begin(), text.end(), blank);
  const auto last = std::find_if_not(text.rbegin(), std::make_reverse_iterator(first), blank).base();
  return {first, last};
}

std::vector<std::string> cells_of(const std::string& line, char separator) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, separator);) cells.push_back(trimmed(cell));
  if (!line.empty() && line.back() == separator) cells.emplace_back();
  return cells;
}

/// How many SI units one unit is.
Result<double> factor_of(const std::string& unit, const std::string& si_unit) { return to_si("1 " + unit, si_unit); }

Result<double> number_of(const std::string& cell) {
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  double value = 0.0;
  const char* first = cell.data() + (cell[0] == '+' ? 1 : 0);
  const auto [end, code] = std::from_chars(first, cell.data() + cell.size(), value);
  if (code != std::errc{} || end != cell.data() + cell.size()) return Error{"\"" + cell + "\" is no number."};
  return value;
}

}  // namespace

Result<CsvFile> CsvFile::read(const fs::path& file) {
  GRANARY_TRY(const std::string text, read_text(file));
  CsvFile csv;
  csv.file_ = file.string();
  char separator = ',';
  std::istringstream lines(text);
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (trimmed(line).empty() || trimmed(line)[0] == '#') continue;
    if (csv.headings_.empty())
      for (const char other : {';', '\t'})
        if (line.find(other) != std::string::npos) separator = other;
    std::vector<std::string> cells = cells_of(line, separator);
    if (csv.headings_.empty()) {
      GRANARY_CHECK(csv.read_headings(cells));
    } else if (cells.size() != csv.headings_.size()) {
      return Error{fmt::format("{}: line {}: it has {} cells, and the first line names {} columns.", csv.file_, number,
                               cells.size(), csv.headings_.size())};
    } else {
      csv.rows_.push_back({number, std::move(cells)});
    }
  }
  if (csv.headings_.empty()) return Error{csv.file_ + ": it is empty; its first line must name the columns."};
  return csv;
}

Status CsvFile::read_headings(const std::vector<std::string>& cells) {
  for (const std::string& cell : cells) {
    const std::size_t bracket = cell.find('[');
    const bool has_unit = bracket != std::string::npos && cell.back() == ']';
    const std::string name = trimmed(cell.substr(0, bracket));
    if (has(name)) return Error{fmt::format("{}: the column \"{}\" is there twice.", file_, name)};
    const std::string unit = has_unit ? trimmed(cell.substr(bracket + 1, cell.size() - bracket - 2)) : "";
    headings_.push_back({name, unit, headings_.size()});
  }
  return {};
}

const CsvFile::Heading* CsvFile::find(const std::string& name) const {
  const auto is = std::find_if(headings_.begin(), headings_.end(), [&](const Heading& h) { return h.name == name; });
  return is == headings_.end() ? nullptr : &*is;
}

Error CsvFile::no_column(const std::string& name) const {
  std::vector<std::string> names;
  for (const Heading& one : headings_) names.push_back(one.name);
  return Error{fmt::format("{}: it has no column \"{}\"; it has: {}.", file_, name, fmt::join(names, ", "))};
}

Result<Column> CsvFile::column(const std::string& name, const std::string& si_unit, bool percent) const {
  const Heading* heading = find(name);
  if (heading == nullptr) return no_column(name);
  if (heading->unit.empty() && si_unit != "1")
    return Error{fmt::format("{0}: the column \"{1}\" has no unit; write it behind the name, such as \"{1} [{2}]\".",
                             file_, name, si_unit)};
  Column column;
  double factor = 1.0;
  if (percent && heading->unit == "%") {
    column.percent = true;
    factor = 0.01;
  } else if (!heading->unit.empty()) {
    const auto converted = factor_of(heading->unit, si_unit);
    if (!converted)
      return Error{fmt::format("{}: the unit of the column \"{} [{}]\": {}", file_, name, heading->unit,
                               converted.error().message)};
    factor = *converted;
  }
  for (const Row& row : rows_) {
    const auto value = number_of(row.cells[heading->at]);
    if (!value)
      return Error{fmt::format("{}: line {}: column \"{}\": {}", file_, row.line, name, value.error().message)};
    column.values.push_back(*value * factor);
  }
  return column;
}

Result<Dataset> read_dataset(const fs::path& file, const std::string& name, const std::string& si_unit) {
  GRANARY_TRY(const Hdf5File h5, Hdf5File::open(file));
  GRANARY_TRY(DataArray data, h5.read(name));
  double factor = 1.0;
  const auto unit = h5.text_attribute(name, "unit");
  if (!unit && si_unit != "1")
    return Error{
        fmt::format("{}: {} has no attribute \"unit\"; give it one, such as \"{}\".", file.string(), name, si_unit)};
  if (unit && *unit != si_unit) {
    const auto converted = factor_of(*unit, si_unit);
    if (!converted) return Error{fmt::format("{}: the unit of {}: {}", file.string(), name, converted.error().message)};
    factor = *converted;
  }
  for (double& value : data.values) value *= factor;
  return Dataset{std::move(data.shape), std::move(data.values)};
}

bool has_dataset(const fs::path& file, const std::string& name) {
  const auto h5 = Hdf5File::open(file);
  return h5 && h5->has(name);
}

}  // namespace granary::campaign
