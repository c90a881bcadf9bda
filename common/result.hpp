// A value, or why there is none. The member names are those of std::expected, which g++ 12 lacks in C++20.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include "common/assert.hpp"

namespace granary {

/// What a program of ours ends with (docs/architecture.md): who has to act next.
enum class Exit : int { ok = 0, bad_input = 2, task_failed = 3, stopped = 4, internal = 70 };

/// Why something could not be done: where, what, what is allowed, what to do next; one message a person can act on.
struct Error {
  std::string message;
  Exit exit = Exit::bad_input;
};

template <class T>
class [[nodiscard]] Result {
 public:
  using value_type = T;

  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}      // NOLINT: implicit on purpose
  Result(Error error) : content_(std::in_place_index<1>, std::move(error)) {}  // NOLINT: implicit on purpose

  bool has_value() const { return content_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  T& value() & { return checked(), std::get<0>(content_); }
  const T& value() const& { return checked(), std::get<0>(content_); }
  T&& value() && { return checked(), std::get<0>(std::move(content_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  const Error& error() const& { return std::get<1>(content_); }
  Error&& error() && { return std::get<1>(std::move(content_)); }

  T value_or(T other) const& { return has_value() ? std::get<0>(content_) : std::move(other); }

 private:
  void checked() const { GRANARY_ASSERT(has_value(), std::get<1>(content_).message); }

  std::variant<T, Error> content_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : failed_(true), error_(std::move(error)) {}  // NOLINT: implicit on purpose

  bool has_value() const { return !failed_; }
  explicit operator bool() const { return has_value(); }
  const Error& error() const& { return error_; }
  Error&& error() && { return std::move(error_); }

 private:
  bool failed_ = false;
  Error error_;
};

using Status = Result<void>;

#define GRANARY_CONCAT_(a, b) a##b
#define GRANARY_CONCAT(a, b) GRANARY_CONCAT_(a, b)

/// GRANARY_TRY(const Hdf5File file, Hdf5File::open(path)): the value, or back to our caller with the error.
#define GRANARY_TRY(declaration, ...) GRANARY_TRY_AS(GRANARY_CONCAT(granary_try_, __LINE__), declaration, __VA_ARGS__)
#define GRANARY_TRY_AS(name, declaration, ...)           \
  auto name = (__VA_ARGS__);                             \
  if (!name.has_value()) return std::move(name).error(); \
  declaration = std::move(name).value()

/// GRANARY_CHECK(file.close()): nothing, or back to our caller with the error.
#define GRANARY_CHECK(...)                                                                 \
  do {                                                                                     \
    auto granary_check_status = (__VA_ARGS__);                                             \
    if (!granary_check_status.has_value()) return std::move(granary_check_status).error(); \
  } while (false)

}  // namespace granary
