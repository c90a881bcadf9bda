#include "common/results/dataset_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <sstream>

namespace granary {
namespace {

using results_schema::Dataset;

// Numbers of integer datasets come back through double: exact up to here. Seeds, which may be larger, are texts.
constexpr std::int64_t kLargestInteger = std::int64_t{1} << 53;

std::vector<std::string> letters_of(std::string_view shape) {
  std::istringstream in{std::string(shape)};
  std::vector<std::string> letters;
  for (std::string letter; in >> letter;) letters.push_back(letter);
  return letters;
}

std::string in_group(std::string_view name, const std::string& group) {
  std::string full(name);
  if (const auto at = full.find("NNNN"); at != std::string::npos) full.replace(at, 4, group);
  return full;
}

std::string joined(const std::vector<std::int64_t>& numbers) { return fmt::format("{}", fmt::join(numbers, ",")); }

/// "0,1" -> {0, 1}; false if it is something else.
bool split(const std::string& text, std::vector<std::int64_t>& numbers) {
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    std::int64_t number = 0;
    const auto [next, code] = std::from_chars(at, end, number);
    if (code != std::errc{} || (next != end && (*next != ',' || next + 1 == end))) return false;
    numbers.push_back(number);
    at = next == end ? end : next + 1;
  }
  return true;
}

std::vector<std::size_t> shape_of(const std::vector<std::vector<double>>& rows) {
  return {rows.size(), rows.empty() ? 0 : rows.front().size()};
}

}  // namespace

std::string ShapeLetters::contradiction(const Dataset& dataset, const std::vector<std::size_t>& shape) {
  const auto letters = letters_of(dataset.shape);
  if (letters.size() != shape.size())
    return fmt::format("{} has {} axes; its shape should be ({})", dataset.name, shape.size(), dataset.shape);
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    std::string letter = letters[axis];
    std::size_t size = shape[axis];
    if (letter == "1") {
      if (size != 1) return fmt::format("{} has {} values; it should have 1", dataset.name, size);
      continue;
    }
    if (letter.ends_with("+1")) {  // edges: one more than classes, or none at all
      letter.resize(letter.size() - 2);
      size = size == 0 ? 0 : size - 1;
    }
    const auto [known, added] = known_.try_emplace(letter, Known{size, std::string(dataset.name)});
    if (!added && known->second.size != size)
      return fmt::format("{} has {} where {} has {} ({})", dataset.name, size, known->second.from, known->second.size,
                         letter);
    if (size == 0) break;  // no rows: how long they would be is unknown
  }
  return "";
}

bool DatasetWriter::fits(const Dataset& dataset, const std::vector<std::size_t>& shape) {
  if (!status_) return false;
  const std::string wrong = letters_.contradiction(dataset, shape);
  if (!wrong.empty()) status_ = Error{"campaign results do not fit together: " + wrong + ".", Exit::internal};
  return wrong.empty();
}

void DatasetWriter::keep(Status status) {
  if (status_ && !status) status_ = std::move(status);
}

void DatasetWriter::enter(std::int64_t number) {
  group_ = fmt::format("{:04}", number);
  letters_.forget();
}

void DatasetWriter::list(const Dataset& dataset, const std::vector<double>& values) {
  if (!fits(dataset, {values.size()})) return;
  keep(file_.write(in_group(dataset.name, group_), {{values.size()}, values}, dataset.unit, dataset.description));
}

void DatasetWriter::list(const Dataset& dataset, const std::vector<std::int64_t>& values) {
  if (dataset.unit == "text") {
    std::vector<std::string> texts;
    for (const auto value : values) texts.push_back(std::to_string(value));
    return list(dataset, texts);
  }
  if (!fits(dataset, {values.size()})) return;
  for (const auto value : values)
    if (value < -kLargestInteger || value > kLargestInteger)
      return keep(Error{fmt::format("campaign results: {} has {}; numbers there end at 2^53.", dataset.name, value),
                        Exit::internal});
  keep(file_.write_integers(in_group(dataset.name, group_), values, dataset.unit, dataset.description));
}

void DatasetWriter::list(const Dataset& dataset, const std::vector<std::string>& values) {
  if (!fits(dataset, {values.size()})) return;
  const std::string name = in_group(dataset.name, group_);
  keep(file_.write_texts(name, values, dataset.description));
  if (status_) keep(file_.attribute(name, "unit", dataset.unit));
}

void DatasetWriter::list(const Dataset& dataset, const std::vector<std::vector<std::int64_t>>& values) {
  std::vector<std::string> texts;
  for (const auto& value : values) texts.push_back(joined(value));
  list(dataset, texts);
}

void DatasetWriter::rows(const Dataset& dataset, const std::vector<std::vector<double>>& values) {
  DataArray data{shape_of(values), {}};
  if (!fits(dataset, data.shape)) return;
  for (const auto& row : values) {
    if (!fits(dataset, {values.size(), row.size()})) return;
    data.values.insert(data.values.end(), row.begin(), row.end());
  }
  keep(file_.write(in_group(dataset.name, group_), data, dataset.unit, dataset.description));
}

void DatasetWriter::tables(const Dataset& dataset, const std::vector<std::vector<std::vector<double>>>& values) {
  DataArray data{{values.size(), 0, 0}, {}};
  if (!values.empty()) data.shape = {values.size(), shape_of(values.front())[0], shape_of(values.front())[1]};
  if (!fits(dataset, data.shape)) return;
  for (const auto& table : values) {
    if (!fits(dataset, {values.size(), table.size(), shape_of(table)[1]})) return;
    for (const auto& row : table) {
      if (!fits(dataset, {values.size(), table.size(), row.size()})) return;
      data.values.insert(data.values.end(), row.begin(), row.end());
    }
  }
  keep(file_.write(in_group(dataset.name, group_), data, dataset.unit, dataset.description));
}

void DatasetReader::fail(std::string message) {
  if (status_) status_ = Error{fmt::format("{}: {}.", name_, message)};
}

bool DatasetReader::fits(const Dataset& dataset, const std::vector<std::size_t>& shape) {
  const std::string wrong = letters_.contradiction(dataset, shape);
  if (!wrong.empty()) fail(wrong);
  return wrong.empty();
}

void DatasetReader::enter(std::int64_t number) {
  group_ = fmt::format("{:04}", number);
  letters_.forget();
}

DataArray DatasetReader::array(const Dataset& dataset) {
  if (!status_) return {};
  auto data = file_.read(in_group(dataset.name, group_));
  if (!data) {
    status_ = std::move(data).error();
    return {};
  }
  return fits(dataset, data->shape) ? std::move(data).value() : DataArray{};
}

void DatasetReader::list(const Dataset& dataset, std::vector<double>& values) { values = array(dataset).values; }

void DatasetReader::list(const Dataset& dataset, std::vector<std::int64_t>& values) {
  if (dataset.unit != "text") {
    for (const double value : array(dataset).values) values.push_back(static_cast<std::int64_t>(value));
    return;
  }
  std::vector<std::vector<std::int64_t>> numbers;
  list(dataset, numbers);
  for (const auto& number : numbers) {
    if (number.size() != 1) return fail(std::string(dataset.name) + " holds a text that is no integer");
    values.push_back(number.front());
  }
}

void DatasetReader::list(const Dataset& dataset, std::vector<std::string>& values) {
  if (!status_) return;
  auto texts = file_.read_texts(in_group(dataset.name, group_));
  if (!texts) {
    status_ = std::move(texts).error();
  } else if (fits(dataset, {texts->size()})) {
    values = std::move(texts).value();
  }
}

void DatasetReader::list(const Dataset& dataset, std::vector<std::vector<std::int64_t>>& values) {
  std::vector<std::string> texts;
  list(dataset, texts);
  for (const auto& text : texts) {
    values.emplace_back();
    if (!split(text, values.back()))
      return fail(fmt::format("{} holds \"{}\"; integers with commas are wanted", dataset.name, text));
  }
}

void DatasetReader::rows(const Dataset& dataset, std::vector<std::vector<double>>& values) {
  const DataArray data = array(dataset);
  if (data.shape.empty()) return;
  const std::size_t length = data.shape[1];
  for (std::size_t row = 0; row < data.shape[0]; ++row)
    values.emplace_back(data.values.begin() + row * length, data.values.begin() + (row + 1) * length);
}

void DatasetReader::tables(const Dataset& dataset, std::vector<std::vector<std::vector<double>>>& values) {
  const DataArray data = array(dataset);
  if (data.shape.empty()) return;
  const std::size_t n_rows = data.shape[1], length = data.shape[2];
  auto at = data.values.begin();
  for (std::size_t table = 0; table < data.shape[0]; ++table) {
    values.emplace_back();
    for (std::size_t row = 0; row < n_rows; ++row, at += length) values.back().emplace_back(at, at + length);
  }
}

}  // namespace granary
