#include "controller/campaign/sections.hpp"

namespace granary::campaign {
namespace {

/// The two items of a list as the members "0" and "1", so that a Reader says where in the list a fault is.
template <class Read>
auto read_pair(json::Reader& reader, const std::string& key, const json::Value& list, json::Problems& problems,
               Read read) -> std::optional<std::array<decltype(read(reader, key)), 2>> {
  if (list.size() != 2) {
    reader.problem(key, "it must be one value for both solids, or a list of two, one for each.");
    return std::nullopt;
  }
  const json::Value both = json::Value::object({{"0", list.items()[0]}, {"1", list.items()[1]}});
  json::Reader items(both, reader.file(), problems, reader.pointer(key));
  return std::array{read(items, "0"), read(items, "1")};
}

template <class T, class Read>
std::array<T, 2> pair_or(json::Reader& reader, const std::string& key, std::array<T, 2> otherwise,
                         json::Problems& problems, Read read) {
  const json::Value* found = reader.raw(key);
  if (found == nullptr) return otherwise;
  if (found->is_array()) return read_pair(reader, key, *found, problems, read).value_or(otherwise);
  const T both = read(reader, key);
  return {both, both};
}

}  // namespace

json::Reader section_or_empty(json::Reader& reader, const std::string& key, json::Problems& problems) {
  static const json::Value empty = json::Value::object();
  if (auto section = reader.optional_section(key)) return *section;
  return {empty, reader.file(), problems, reader.pointer(key)};
}

std::array<int, 2> integer_pair_or(json::Reader& reader, const std::string& key, std::array<int, 2> otherwise,
                                   json::Range range, json::Problems& problems) {
  return pair_or(reader, key, otherwise, problems, [&](json::Reader& from, const std::string& name) {
    return static_cast<int>(from.integer_or(name, otherwise[0], range));
  });
}

std::array<double, 2> number_pair_or(json::Reader& reader, const std::string& key, std::array<double, 2> otherwise,
                                     json::Range range, json::Problems& problems) {
  return pair_or(reader, key, otherwise, problems, [&](json::Reader& from, const std::string& name) {
    return from.number_or(name, otherwise[0], range);
  });
}

std::array<double, 2> quantity_pair_or(json::Reader& reader, const std::string& key, std::array<double, 2> otherwise,
                                       const std::string& si_unit, json::Range range, json::Problems& problems) {
  return pair_or(reader, key, otherwise, problems, [&](json::Reader& from, const std::string& name) {
    return from.quantity_or(name, otherwise[0], si_unit, range);
  });
}

std::string without_folder(std::string message, const std::filesystem::path& folder) {
  const std::string prefix = folder.string() + "/";
  if (message.starts_with(prefix)) message.erase(0, prefix.size());
  return message;
}

bool is_auto(json::Reader& reader, const std::string& key) {
  const json::Value* found = reader.raw(key);
  if (found == nullptr) return true;
  if (!found->is_string() || found->as_string().find_first_of("0123456789") != std::string::npos) return false;
  if (found->as_string() != "auto")
    reader.problem(key, "it must be \"auto\" or a value.", "See docs/workflow_format.md#dem.");
  return true;
}

}  // namespace granary::campaign
