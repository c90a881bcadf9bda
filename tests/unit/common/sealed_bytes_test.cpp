#include "common/results/sealed_bytes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "common/results/hdf5_file.hpp"

namespace granary {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::HasSubstr;

class Sealed : public ::testing::Test {
 protected:
  Sealed() : folder_(fs::temp_directory_path() / ("granary-sealed-" + std::to_string(getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~Sealed() override { fs::remove_all(folder_); }

  fs::path path(const std::string& name = "file") const { return folder_ / name; }
  static void put(const fs::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
  }
  static std::string bytes_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
  }
  /// What a reader gets behind the head; "" if the file is refused.
  static std::string content_of(const fs::path& file) {
    const auto opened = SealedBytes::open(file);
    if (!opened) return "";
    std::string content(opened->size() - SealedBytes::kHead, '?');
    EXPECT_TRUE(opened->read(SealedBytes::kHead, content.size(), content.data()));
    return content;
  }
  static std::string refusal(const fs::path& file) {
    const auto opened = SealedBytes::open(file);
    return opened ? "accepted" : opened.error().message;
  }
  /// A sealed file of n bytes of content.
  fs::path written(std::size_t n) const {
    auto file = SealedBytes::create(path());
    const std::string content(n, 'a');
    EXPECT_TRUE(file->write(SealedBytes::kHead, n, content.data()) && file->commit(0));
    return path();
  }

 private:
  fs::path folder_;
};

TEST_F(Sealed, GivesBackWhatWasCommittedAndNothingElse) {
  auto file = SealedBytes::create(path());
  ASSERT_TRUE(file->write(512, 5, "hello"));
  ASSERT_TRUE(file->commit(0));
  ASSERT_TRUE(file->write(512, 5, "HELLO"));  // never committed

  { const auto gone = std::move(file); }

  EXPECT_EQ(content_of(path()), "hello");
}

TEST_F(Sealed, RefusesEveryChangedByte) {
  const fs::path file = written(5000);
  const std::string whole = bytes_of(file);

  // Of the two seals only the newer one counts, in the second slot or the first by turns: read both as one.
  for (std::size_t at = SealedBytes::kHead; at < whole.size(); ++at) {
    std::string bad = whole;
    bad[at] = static_cast<char>(bad[at] ^ (1 << at % 8));
    put(file, bad);
    ASSERT_THAT(refusal(file), HasSubstr("damaged")) << "byte " << at;
  }
}

TEST_F(Sealed, GivesTheSameOrNothingForEveryChangedByteOfItsSeals) {
  const fs::path file = written(100);
  const std::string whole = bytes_of(file);

  for (std::size_t at = 0; at < SealedBytes::kHead; ++at) {
    std::string bad = whole;
    bad[at] = static_cast<char>(bad[at] ^ 0x10);
    put(file, bad);
    ASSERT_THAT(content_of(file), AnyOf("", std::string(100, 'a'))) << "byte " << at;
  }
}

TEST_F(Sealed, RefusesEveryShorterLength) {
  const fs::path file = written(3000);
  const std::string whole = bytes_of(file);

  for (std::size_t length = 0; length < whole.size(); ++length) {
    put(file, whole.substr(0, length));
    ASSERT_NE(refusal(file), "accepted") << length << " bytes";
  }
}

TEST_F(Sealed, CutAtAnyByteOfACommitHoldsTheOldOrTheNew) {
  for (const std::size_t n_before : {100u, 9000u}) {
    auto file = SealedBytes::create(path("live"));
    const std::string before(n_before, 'a'), changed(3000, 'b');
    ASSERT_TRUE(file->write(512, before.size(), before.data()) && file->commit(0));
    const std::string on_disk = bytes_of(path("live"));
    ASSERT_TRUE(file->write(700, changed.size(), changed.data()));    // over old bytes, and behind a short end
    ASSERT_TRUE(file->write(14000, changed.size(), changed.data()));  // behind the end
    std::string after = before;
    after.resize(14000 + changed.size() - 512, '\0');
    after.replace(700 - 512, changed.size(), changed).replace(14000 - 512, changed.size(), changed);

    std::string so_far = on_disk;
    bool is_new = false;
    for (const SealedBytes::Write& step : file->plan(0))
      for (std::size_t cut = 0; cut < step.bytes.size(); ++cut) {
        // A few cuts in the long writes, each in the seals.
        if (so_far.size() < step.at + cut + 1) so_far.resize(step.at + cut + 1, '\0');
        so_far[step.at + cut] = step.bytes[cut];
        if (step.bytes.size() > 512 && cut % 97 != 0 && cut + 1 < step.bytes.size()) continue;
        put(path("cut"), so_far);
        const std::string content = content_of(path("cut"));
        ASSERT_TRUE(content == after || (!is_new && content == before)) << n_before << ", " << step.at + cut;
        is_new = content == after;
      }
    EXPECT_TRUE(is_new);
  }
}

TEST_F(Sealed, TellsAFileWithoutASealFromADamagedOne) {
  put(path(), "just some text");
  EXPECT_FALSE(SealedBytes::seems_sealed(path()));
  EXPECT_THAT(refusal(path()), HasSubstr("no whole seal"));
  EXPECT_THAT(refusal(path("none")), HasSubstr("no such file"));
  EXPECT_THAT(refusal(path().parent_path()), HasSubstr("a file is wanted"));
}

TEST_F(Sealed, IsNotReadWhileItIsWritten) {
  const auto file = SealedBytes::create(path());

  EXPECT_THAT(refusal(path()), HasSubstr("another program has it open"));
}

TEST_F(Sealed, Hdf5FileEndsWithItsLastFlush) {
  {
    auto h5 = Hdf5File::create_sealed(path());
    ASSERT_TRUE(h5) << h5.error().message;
    ASSERT_TRUE(h5->create_growing("/time", {}, "s", ""));
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(h5->append_row("/time", {double(i)}) && h5->flush());
    fs::copy_file(path(), path("killed"));
    ASSERT_TRUE(h5->append_row("/time", {3.0}));
    EXPECT_EQ(bytes_of(path()), bytes_of(path("killed")));
  }

  EXPECT_EQ(Hdf5File::open(path("killed"))->read("/time")->values, (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(Hdf5File::open_sealed(path())->read("/time")->values, (std::vector<double>{0, 1, 2, 3}));
}

TEST_F(Sealed, AnHdf5FileWithoutASealIsReadOnlyWhereNoneIsAskedFor) {
  { ASSERT_TRUE(Hdf5File::create(path())->write("/x", {{1}, {7.0}}, "", "")); }

  EXPECT_EQ(Hdf5File::open(path())->read("/x")->values, std::vector<double>{7.0});
  EXPECT_THAT(Hdf5File::open_sealed(path()).error().message, HasSubstr("no whole seal"));
}

}  // namespace
}  // namespace granary
