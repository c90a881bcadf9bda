// Files of lines that grow with the DEM clock (fragments.jsonl, breaks.jsonl, tallies.jsonl): what a run that was cut
// told after the state it now goes on from will be told again.
#pragma once

#include <string>

#include "common/json/io.hpp"
#include "common/result.hpp"

namespace granary::dem {

/// Takes out lines whose time_s lies after `time` [s], and a last line that is not whole; makes no file. Lines without
/// a time_s stay. Errors: a line that is not JSON; a full disk.
Status forget_lines_after(const std::string& file, double time);

/// A writer that goes on after what was told up to `time`.
Result<json::LineWriter> go_on_telling(const std::string& file, double time);

}  // namespace granary::dem
