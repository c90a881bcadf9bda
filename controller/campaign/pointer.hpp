// JSON pointers (RFC 6901): places in a document.
#pragma once

#include <string>
#include <vector>

#include "common/json/value.hpp"

namespace granary::campaign {

/// "/a~1b/0" -> {"a/b", "0"}. A pointer that does not begin with "/" has no steps.
std::vector<std::string> steps_of(const std::string& pointer);

/// One step further: "/dem", "a/b" -> "/dem/a~1b".
std::string with_step(const std::string& pointer, const std::string& step);

/// The index a step names in an array of that size, or -1. "-" is the place after the last.
long index_of(const std::string& step, std::size_t size);

/// What is there; nullptr if nothing is.
const json::Value* find(const json::Value& document, const std::string& pointer);

/// Whether `place` is `outer` or somewhere in it.
bool is_within(const std::string& place, const std::string& outer);

}  // namespace granary::campaign
