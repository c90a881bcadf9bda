#include "pilot/journal/journal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "common/files.hpp"

namespace granary::pilot {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class JournalTest : public ::testing::Test {
 protected:
  // In memory where there is such a place: these tests write hundreds of small files.
  fs::path dir = (fs::exists("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path()) /
                 ("granary_journal_" + std::to_string(::getpid()));
  fs::path file = dir / "journal.jsonl";
  void SetUp() override { fs::create_directories(dir); }
  void TearDown() override { fs::remove_all(dir); }

  void write_records(int count) {
    auto journal = Journal::open(file, [] { return 1.5; });
    ASSERT_TRUE(journal.has_value());
    for (int k = 0; k < count; ++k) {
      ASSERT_TRUE(
          journal->append("test.number", json::Value::object({{"k", k}, {"text", "line\n\"quoted\""}})).has_value());
    }
  }
  std::string text() const { return *read_text(file); }
  void replace(const std::string& content) { std::ofstream(file, std::ios::binary | std::ios::trunc) << content; }
};

TEST_F(JournalTest, ReadsBackWhatWasAppended) {
  write_records(3);

  const auto content = read_journal(file);

  ASSERT_TRUE(content.has_value());
  ASSERT_EQ(content->records.size(), 3u);
  EXPECT_EQ(content->records[2].sequence, 3u);
  EXPECT_EQ(content->records[2].kind, "test.number");
  EXPECT_EQ(content->records[2].wall_time, 1.5);
  EXPECT_EQ(content->records[2].payload.integer_or("k", -1), 2);
  EXPECT_EQ(content->records[2].payload.text_or("text", ""), "line\n\"quoted\"");
  EXPECT_EQ(content->dropped_bytes, 0u);
}

TEST_F(JournalTest, CutAtAnyByteKeepsEveryWholeRecordAndGoesOn) {
  write_records(4);
  const std::string whole = text();
  std::vector<std::size_t> ends;
  for (std::size_t at = 0; (at = whole.find('\n', at)) != std::string::npos; ++at) ends.push_back(at + 1);

  for (std::size_t length = 0; length <= whole.size(); ++length) {
    replace(whole.substr(0, length));
    const auto n_whole =
        static_cast<std::size_t>(std::count_if(ends.begin(), ends.end(), [&](std::size_t e) { return e <= length; }));
    const std::size_t kept = n_whole == 0 ? 0 : ends[n_whole - 1];
    auto journal = Journal::open(file);
    ASSERT_TRUE(journal.has_value()) << length;
    EXPECT_EQ(journal->records().size(), n_whole) << length;
    EXPECT_EQ(journal->dropped_bytes(), length - kept) << length;

    ASSERT_TRUE(journal->append("test.more", json::Value::object()).has_value());

    const auto again = read_journal(file);
    ASSERT_TRUE(again.has_value()) << length;
    ASSERT_EQ(again->records.size(), n_whole + 1) << length;
    EXPECT_EQ(again->records.back().sequence, n_whole + 1);
    EXPECT_EQ(again->dropped_bytes, 0u);
  }
}

TEST_F(JournalTest, DropsALastLineWithAFlippedBitAnywhere) {
  write_records(2);
  const std::string whole = text();
  const std::size_t second = whole.find('\n') + 1;

  for (std::size_t bit = 8 * second; bit + 8 < 8 * whole.size(); ++bit) {
    const std::size_t at = bit / 8;
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 1 << bit % 8);
    if (damaged[at] == '\n') continue;
    replace(damaged);
    const auto content = read_journal(file);
    ASSERT_TRUE(content.has_value()) << bit;
    EXPECT_EQ(content->records.size(), 1u) << bit;
    EXPECT_EQ(content->dropped_bytes, whole.size() - second) << bit;
  }
}

TEST_F(JournalTest, GoesOnBehindLinesWithTheSumsOfEarlierVersionsAndSeesTheirDamage) {
  const std::string old =
      R"({"n":1,"wall_s":1795340272.320125,"kind":"other.note","payload":{"text":"old"},"sum":"9afe5da6e2042814"})"
      "\n";
  replace(old);
  {
    auto journal = Journal::open(file);
    ASSERT_TRUE(journal.has_value());
    ASSERT_TRUE(journal->append("other.note", json::Value::object({{"text", "new"}})).has_value());
  }
  const auto content = read_journal(file);
  ASSERT_TRUE(content.has_value());
  ASSERT_EQ(content->records.size(), 2u);
  EXPECT_EQ(content->records[0].payload.text_or("text", ""), "old");
  EXPECT_DOUBLE_EQ(content->records[0].wall_time, 1795340272.320125);

  std::string damaged = old;
  damaged[damaged.find("old")] = 'c';
  replace(damaged);
  EXPECT_EQ(read_journal(file)->records.size(), 0u);
}

TEST_F(JournalTest, DropsTheZerosThatAPowerCutLeavesBehind) {
  write_records(2);
  replace(text() + std::string(100, '\0'));

  const auto content = read_journal(file);

  ASSERT_TRUE(content.has_value());
  EXPECT_EQ(content->records.size(), 2u);
  EXPECT_EQ(content->dropped_bytes, 100u);
}

TEST_F(JournalTest, RefusesADamagedLineInTheMiddleAndNamesIt) {
  write_records(4);
  std::string damaged = text();
  damaged[damaged.find("\"k\":1") + 4] = '7';
  replace(damaged);

  const auto content = read_journal(file);

  ASSERT_FALSE(content.has_value());
  EXPECT_THAT(content.error().message, HasSubstr("line 2 is damaged or missing"));
  EXPECT_THAT(content.error().message, HasSubstr(file.string()));
}

TEST_F(JournalTest, RefusesAMissingLineInTheMiddle) {
  write_records(3);
  std::string damaged = text();
  const std::size_t first = damaged.find('\n') + 1, second = damaged.find('\n', first) + 1;
  damaged.erase(first, second - first);
  replace(damaged);

  EXPECT_FALSE(read_journal(file).has_value());
}

TEST_F(JournalTest, AMissingFileIsAnEmptyJournal) {
  const auto content = read_journal(file);

  ASSERT_TRUE(content.has_value());
  EXPECT_TRUE(content->records.empty());
}

TEST(Journal, SaysClearlyThatTheDiskIsFull) {
  auto journal = Journal::open("/dev/full");
  ASSERT_TRUE(journal.has_value());

  const Status appended = journal->append("test.number", json::Value::object({{"k", 1}}));

  ASSERT_FALSE(appended.has_value());
  EXPECT_THAT(appended.error().message, HasSubstr("the disk is full"));
  EXPECT_EQ(appended.error().exit, Exit::stopped);
  EXPECT_FALSE(journal->healthy().has_value());
}

}  // namespace
}  // namespace granary::pilot
