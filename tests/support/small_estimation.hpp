// quick_estimate with short bursts, a few rounds and a coarse balance: a campaign that fits, of some seconds.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "pilot/journal/journal.hpp"
#include "tests/support/granary_program.hpp"

namespace granary::test {

/// Arguments of `granary COMMAND`, with further settings.
inline std::vector<std::string> small_estimation(const std::string& command, const fs::path& dir,
                                                 std::vector<std::string> settings = {}) {
  std::vector<std::string> arguments{command, (kSource / "workflows/quick_estimate.json").string(), "--dir",
                                     dir.string()};
  for (const char* setting : {"/dem/longest_burst=\"0.2 s\"", "/coupling/most_rounds=3", "/pbm/bins=12",
                              "/pbm/longest_burst=\"4 s\"", "/pbm/tolerance=0.01", "/process/duration=\"14 s\""})
    settings.insert(settings.begin(), setting);
  for (const std::string& setting : settings) arguments.insert(arguments.end(), {"--set", setting});
  return arguments;
}

/// The records of one kind in a campaign's journal.
inline std::vector<pilot::Record> records(const fs::path& dir, const std::string& kind) {
  const auto content = pilot::read_journal(dir / "journal.jsonl");
  EXPECT_TRUE(content) << (content ? "" : content.error().message);
  std::vector<pilot::Record> found;
  if (content)
    std::copy_if(content->records.begin(), content->records.end(), std::back_inserter(found),
                 [&](const pilot::Record& record) { return record.kind == kind; });
  return found;
}

}  // namespace granary::test
