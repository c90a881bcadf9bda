// What a journal tells of idle cores, on a campaign of two of them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "controller/bench/idle_cores.hpp"
#include "pilot/journal/journal.hpp"

namespace granary::bench {
namespace {

namespace fs = std::filesystem;
using json::Value;

TEST(IdleCores, AreCountedFromTheEndOfOneProcessToTheBeginOfTheNextOnThatCore) {
  const fs::path file = fs::temp_directory_path() / ("granary_idle_" + std::to_string(getpid()) + ".jsonl");
  fs::remove(file);
  {
    auto journal = pilot::Journal::open(file);
    ASSERT_TRUE(journal) << journal.error().message;
    const auto write = [&](const char* kind, double time, int id, const char* cores = nullptr) {
      Value payload = Value::object({{"time_s", time}, {"id", id}});
      if (cores != nullptr) payload.set("cores", cores);
      ASSERT_TRUE(journal->append(kind, payload));
    };
    const auto submit = [&](int id, double time, bool fill) {
      ASSERT_TRUE(journal->append(
          "task.submit", Value::object({{"time_s", time}, {"id", id}, {"task", Value::object({{"fill", fill}})}})));
    };
    Value nodes = Value::array();
    nodes.push(Value::object({{"name", "here"}, {"cores", 2}}));
    ASSERT_TRUE(journal->append("pilot.open", Value::object({{"time_s", 0.0}, {"nodes", nodes}})));
    submit(0, 0.0, false);
    submit(2, 0.0, false);
    submit(1, 3.0, true);  // the first rates
    submit(3, 3.0, true);
    write("task.place", 0.0, 0, "0");  // a DEM on the first core
    write("task.start", 0.5, 0);
    write("task.place", 3.0, 1, "1");
    write("task.start", 3.0625, 1);
    write("task.exit", 4.0, 0);
    write("task.place", 4.1, 3, "0");  // the DEM's core at work
    write("task.start", 4.25, 3);
    write("task.suspend", 5.0, 3);
    write("task.place", 5.0, 2, "0");  // a PBM takes it back
    write("task.start", 5.125, 2);
    write("task.exit", 6.0, 1);
    write("task.resume", 6.5, 3, "1");
    write("task.exit", 8.0, 2);
    write("estimation.over", 9.0, 0);
    write("task.exit", 100.0, 3);
  }

  const auto seen = idle_cores_of(file);

  ASSERT_TRUE(seen) << seen.error().message;
  EXPECT_EQ(seen->put_to_work, (std::vector{0.0625, 0.25, 0.5}));
  EXPECT_EQ(seen->given_back, (std::vector{0.125}));
  EXPECT_DOUBLE_EQ(seen->before_rates, 0.5 + 3.0);
  EXPECT_DOUBLE_EQ(seen->at_switches, 0.0625 + 0.25 + 0.125 + 0.5);
  EXPECT_DOUBLE_EQ(seen->afterwards, 1.0);
  fs::remove(file);
}

}  // namespace
}  // namespace granary::bench
