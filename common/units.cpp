#include "common/units.hpp"

#include <fmt/format.h>
#include <udunits2.h>

#include <charconv>
#include <cmath>
#include <memory>
#include <mutex>

namespace granary {
namespace {

using Unit = std::unique_ptr<ut_unit, decltype(&ut_free)>;

/// UDUNITS' own database, read once. It knows rpm; messages are ours, not its own.
ut_system* unit_system() {
  static ut_system* const system = [] {
    ut_set_error_message_handler(ut_ignore);
    return ut_read_xml(nullptr);
  }();
  return system;
}

Unit parse_unit(const std::string& text) { return {ut_parse(unit_system(), text.c_str(), UT_UTF8), &ut_free}; }

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

Result<double> to_si(std::string_view text, const std::string& si_unit) {
  static std::mutex one_at_a_time;  // UDUNITS keeps its state in globals
  const std::lock_guard lock(one_at_a_time);
  if (unit_system() == nullptr)
    return Error{"the units database of UDUNITS-2 was not found; install libudunits2-0.", Exit::internal};

  const std::string_view whole = trimmed(text);
  double number = 0.0;
  const auto [end, code] = std::from_chars(whole.data(), whole.data() + whole.size(), number);
  if (code != std::errc{} || !std::isfinite(number))
    return Error{fmt::format("it must be a number with a unit, such as \"1 {}\".", si_unit)};
  const std::string unit_text{trimmed(whole.substr(static_cast<std::size_t>(end - whole.data())))};
  if (unit_text.empty()) return Error{fmt::format("it has no unit; write for example \"{} {}\".", number, si_unit)};

  const Unit from = parse_unit(unit_text);
  if (!from) return Error{fmt::format("\"{}\" is not a unit; use one of the kind of {}.", unit_text, si_unit)};
  const Unit to = parse_unit(si_unit);
  if (!to) return Error{"the program asks for the unknown unit " + si_unit + ".", Exit::internal};
  const std::unique_ptr<cv_converter, decltype(&cv_free)> converter(ut_get_converter(from.get(), to.get()), &cv_free);
  if (!converter) return Error{fmt::format("{} is not of the kind wanted; use a unit such as {}.", unit_text, si_unit)};
  return cv_convert_double(converter.get(), number);
}

}  // namespace granary
