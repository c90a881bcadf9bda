#include "controller/campaign/data_file.hpp"

#include <fmt/format.h>

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

struct Heading {
  std::string name;
  double factor = 1.0;
  bool percent = false;
};

Result<Heading> heading_of(const std::string& cell, const std::vector<WantedColumn>& wanted) {
  const std::size_t bracket = cell.find('[');
  const bool has_unit = bracket != std::string::npos && cell.back() == ']';
  const std::string name = trimmed(cell.substr(0, bracket));
  const auto is = std::find_if(wanted.begin(), wanted.end(), [&](const WantedColumn& one) { return one.name == name; });
  if (is == wanted.end()) {
    std::string names;
    for (const WantedColumn& one : wanted) names += (names.empty() ? "" : ", ") + one.name;
    return Error{fmt::format("the column \"{}\" is none of: {}.", cell, names)};
  }
  if (!has_unit && is->si_unit != "1")
    return Error{fmt::format("the column \"{0}\" has no unit; write it behind the name, such as \"{0} [{1}]\".", name,
                             is->si_unit)};
  if (!has_unit) return Heading{name, 1.0, false};
  const std::string unit = trimmed(cell.substr(bracket + 1, cell.size() - bracket - 2));
  if (is->percent && unit == "%") return Heading{name, 0.01, true};
  const auto factor = factor_of(unit, is->si_unit);
  if (!factor) return Error{fmt::format("the unit of the column \"{}\": {}", cell, factor.error().message)};
  return Heading{name, *factor, false};
}

Result<double> number_of(const std::string& cell) {
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  double value = 0.0;
  const char* first = cell.data() + (cell[0] == '+' ? 1 : 0);
  const auto [end, code] = std::from_chars(first, cell.data() + cell.size(), value);
  if (code != std::errc{} || end != cell.data() + cell.size()) return Error{"\"" + cell + "\" is no number."};
  return value;
}

}  // namespace

Result<Table> read_csv(const fs::path& file, const std::vector<WantedColumn>& wanted) {
  GRANARY_TRY(const std::string text, read_text(file));
  Table table;
  std::vector<Heading> headings;
  char separator = ',';
  std::istringstream lines(text);
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const auto fault = [&](const std::string& what) {
      return Error{fmt::format("{}: line {}: {}", file.string(), number, what)};
    };
    if (trimmed(line).empty() || trimmed(line)[0] == '#') continue;
    if (headings.empty()) {
      for (const char other : {';', '\t'})
        if (line.find(other) != std::string::npos) separator = other;
      for (const std::string& cell : cells_of(line, separator)) {
        auto heading = heading_of(cell, wanted);
        if (!heading) return fault(heading.error().message);
        if (!table.try_emplace(heading->name, Column{{}, heading->percent}).second)
          return fault(fmt::format("the column \"{}\" is there twice.", heading->name));
        headings.push_back(*heading);
      }
      continue;
    }
    const auto cells = cells_of(line, separator);
    if (cells.size() != headings.size())
      return fault(fmt::format("it has {} cells, and the first line names {} columns.", cells.size(), headings.size()));
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const auto value = number_of(cells[k]);
      if (!value) return fault(value.error().message);
      table[headings[k].name].values.push_back(*value * headings[k].factor);
    }
  }
  if (headings.empty()) return Error{file.string() + ": it is empty; its first line must name the columns."};
  return table;
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
