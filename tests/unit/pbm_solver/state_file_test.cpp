#include "pbm_solver/output/state_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "pbm_solver/model/model_tables.hpp"
#include "tests/support/pbm_cases.hpp"

namespace granary::pbm {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class StateFiles : public ::testing::Test {
 protected:
  StateFiles() : folder_(fs::temp_directory_path() / ("granary-states-" + std::to_string(getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    case_ = testing::a_granulator(3, 2);
    case_.initial = {{-1, 0, 1, 1e7, 1e-12, 2e-12}, {1, 2, 2, 3.0, 1e-15, 0.0}};
  }
  ~StateFiles() override { fs::remove_all(folder_); }

  Snapshot state_at(double time) const {
    Snapshot s = initial_snapshot(case_, grid());
    s.time = time;
    s.next_step = 0.25;
    s.last_error = 0.5;
    s.number[1] += time;
    return s;
  }
  ClassGrid grid() const { return ClassGrid(case_.grid); }
  fs::path out() const { return folder_ / "out.h5"; }
  fs::path folder() const { return folder_; }

  void append(StateFile& file, const Snapshot& s) const { ASSERT_TRUE(file.append(s, summarize(s, case_, grid()))); }
  /// out.h5 with states at 0, 1 and 2 s, the last one changed.
  template <class Change>
  void write_out(Change change) const {
    auto file = StateFile::create(out(), case_, grid());
    ASSERT_TRUE(file) << file.error().message;
    append(*file, state_at(0.0));
    append(*file, state_at(1.0));
    Snapshot last = state_at(2.0);
    change(last);
    append(*file, last);
  }
  /// A file of states whose datasets a test writes itself, each as it wants.
  Result<Hdf5File> head_only(const PbmCase& c) const {
    { EXPECT_TRUE(StateFile::create(folder_ / "model.h5", c, ClassGrid(c.grid))); }
    auto h5 = Hdf5File::create_sealed(out());
    EXPECT_TRUE(h5->attribute("/", "format", "granary-pbm-out-1"));
    for (const char* name : {"/grid/solid_1", "/grid/solid_2"})
      EXPECT_TRUE(h5->write(name, *Hdf5File::open(folder_ / "model.h5")->read(name), "m^3", ""));
    EXPECT_TRUE(h5->write("/state/time", {{1}, {0.0}}, "s", ""));
    return h5;
  }

  Result<Snapshot> restart(std::optional<double> time = {}) const {
    return read_restart(Restart{out(), time}, case_, grid());
  }
  std::string refusal(std::optional<double> time = {}) const {
    const auto read = restart(time);
    return read ? "accepted" : read.error().message;
  }
  static std::string bytes_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
  }
  void put(const std::string& bytes) const { std::ofstream(out(), std::ios::binary | std::ios::trunc) << bytes; }

  PbmCase case_;

 private:
  fs::path folder_;
};

const auto as_it_is = [](Snapshot&) {};

TEST_F(StateFiles, GiveBackEveryStateToTheBit) {
  write_out(as_it_is);

  for (const double time : {0.0, 1.0, 2.0}) {
    const auto read = restart(time);
    ASSERT_TRUE(read) << read.error().message;
    const Snapshot wanted = state_at(time);
    EXPECT_EQ(read->number, wanted.number);
    EXPECT_EQ(read->liquid, wanted.liquid);
    EXPECT_EQ(read->gas, wanted.gas);
    EXPECT_EQ(read->ledger, wanted.ledger);
    EXPECT_EQ(read->next_step, 0.25);
    EXPECT_EQ(read->last_error, 0.5);
  }
  EXPECT_EQ(restart()->time, 2.0);
}

TEST_F(StateFiles, ARowThatWasNotFinishedIsNotThere) {
  auto file = StateFile::create(out(), case_, grid());
  append(*file, state_at(0.0));
  const std::string one_row = bytes_of(out());
  append(*file, state_at(1.0));
  const std::string two_rows = bytes_of(out());
  { const auto closed = std::move(file); }

  // Killed while the second row was written: what is new lies behind the old end, the rest is as it was.
  put(one_row + two_rows.substr(one_row.size()));
  EXPECT_EQ(restart()->time, 0.0);
  put(two_rows);
  EXPECT_EQ(restart()->time, 1.0);
}

TEST_F(StateFiles, RefuseEveryFlippedBitOfACheckpoint) {
  ASSERT_TRUE(write_checkpoint(out(), case_, grid(), state_at(3.0)));
  const std::string whole = bytes_of(out());
  ASSERT_EQ(restart()->time, 3.0);

  for (std::size_t at = 512; at < whole.size(); at += 499) {
    std::string bad = whole;
    bad[at] = static_cast<char>(bad[at] ^ (1 << at % 8));
    put(bad);
    ASSERT_THAT(refusal(), AllOf(HasSubstr("out.h5"), HasSubstr("damaged"))) << at;
  }
}

TEST_F(StateFiles, RefuseAFileCutShortOrOfAnotherKind) {
  ASSERT_TRUE(write_checkpoint(out(), case_, grid(), state_at(3.0)));
  const std::string whole = bytes_of(out());

  put(whole.substr(0, whole.size() - 1));
  EXPECT_THAT(refusal(), HasSubstr("damaged: it has"));
  put("");
  EXPECT_THAT(refusal(), HasSubstr("no whole seal"));
  put(whole.substr(512));  // the HDF5 file itself
  EXPECT_THAT(refusal(), HasSubstr("no whole seal"));
  fs::remove(out());
  EXPECT_THAT(refusal(), HasSubstr("no such file"));
  fs::create_directory(out());
  EXPECT_THAT(refusal(), HasSubstr("a file is wanted"));
}

TEST_F(StateFiles, RefuseValuesNoStateCanHaveAndNameThem) {
  const std::tuple<const char*, void (*)(Snapshot&), const char*> faults[] = {
      {"/state/number", [](Snapshot& s) { s.number[4] = kNan; }, "nan in row 2, place 4"},
      {"/state/number", [](Snapshot& s) { s.number[4] = -1.0; }, "-1 in row 2, place 4"},
      {"/state/liquid", [](Snapshot& s) { s.liquid[17] = kInfinity; }, "inf in row 2, place 17"},
      {"/state/liquid", [](Snapshot& s) { s.liquid[0] = -1e-20; }, "-1e-20 in row 2, place 0"},
      {"/state/gas", [](Snapshot& s) { s.gas[9] = -kInfinity; }, "-inf in row 2, place 9"},
      {"/state/ledger", [](Snapshot& s) { s.ledger[20] = kNan; }, "nan in row 2, place 20"},
      {"/state/next_step", [](Snapshot& s) { s.next_step = kNan; }, "nan in row 2"},
      {"/state/next_step", [](Snapshot& s) { s.next_step = -1.0; }, "-1 in row 2"},
      {"/state/last_error", [](Snapshot& s) { s.last_error = kInfinity; }, "inf in row 2"},
      {"/state/time", [](Snapshot& s) { s.time = kNan; }, "nan in row 2"},
      {"/state/time", [](Snapshot& s) { s.time = 0.5; }, "0.5 in row 2"}};

  for (const auto& [dataset, change, fault] : faults) {
    write_out(change);
    EXPECT_THAT(refusal(), AllOf(HasSubstr(out().string()), HasSubstr(dataset), HasSubstr(fault)));
  }
}

TEST_F(StateFiles, KeepRoundOffBelowZeroAsItIs) {
  write_out([](Snapshot& s) { s.number[5] = -1e-13 * 1e7; });

  EXPECT_EQ(restart()->number[5], -1e-13 * 1e7);
}

TEST_F(StateFiles, OfAnotherGridAreRefusedWithBothGrids) {
  write_out(as_it_is);
  case_.grid.bins = {4, 3};
  EXPECT_THAT(refusal(), AllOf(HasSubstr("another grid: 3 classes"), HasSubstr("the case has 4 classes")));
  case_.grid.bins = {3, 3};
  case_.grid.ratio = {2.0, 3.0};
  EXPECT_THAT(refusal(), HasSubstr("another grid"));
  case_.grid.ratio = {3.0, 3.0};
  case_.compartments = {3, {1e-3, 1e-3, 1e-3}, 20.0};
  EXPECT_THAT(refusal(), AllOf(HasSubstr("2 compartments; "), HasSubstr("3 compartments. ")));
}

TEST_F(StateFiles, NameTheTimesTheyHave) {
  write_out(as_it_is);
  EXPECT_THAT(refusal(1.5), HasSubstr("no state at 1.5 s (/restart/time); it has 3 from 0 s to 2 s"));

  { ASSERT_TRUE(StateFile::create(out(), case_, grid())); }
  EXPECT_THAT(refusal(), HasSubstr("no state yet"));
}

TEST_F(StateFiles, RefuseDatasetsThatAreMissingOrMisshapen) {
  { ASSERT_TRUE(head_only(case_)); }
  EXPECT_THAT(refusal(), HasSubstr("\"/state/number\" is missing"));

  { ASSERT_TRUE(head_only(case_)->write("/state/number", {{18}, std::vector<double>(18)}, "", "")); }
  EXPECT_THAT(refusal(), HasSubstr("\"/state/number\" has 1 dimensions"));

  { ASSERT_TRUE(head_only(case_)->write("/state/number", {{1, 2, 9, 1}, std::vector<double>(18)}, "", "")); }
  EXPECT_THAT(refusal(), AllOf(HasSubstr("shape (1, 2, 9, 1)"), HasSubstr("(2, 3, 3) is wanted")));

  { ASSERT_TRUE(head_only(case_)->write("/state/number", {{0, 2, 3, 3}, {}}, "", "")); }
  EXPECT_THAT(refusal(), HasSubstr("\"/state/number\" has 0 rows; row 0 was asked for"));

  { ASSERT_TRUE(head_only(case_)->write_texts("/state/number", {"many"}, "")); }
  EXPECT_THAT(refusal(), HasSubstr("\"/state/number\" is missing or cannot be read"));

  { ASSERT_TRUE(head_only(case_)->attribute("/", "format", 1.0)); }
  EXPECT_THAT(refusal(), HasSubstr("no file of states"));
}

TEST_F(StateFiles, ACheckpointThatCannotBeWrittenLeavesTheOneBefore) {
  ASSERT_TRUE(write_checkpoint(out(), case_, grid(), state_at(3.0)));
  fs::create_directory(out().string() + ".new");

  EXPECT_FALSE(write_checkpoint(out(), case_, grid(), state_at(4.0)));

  EXPECT_EQ(restart()->time, 3.0);
}

}  // namespace
}  // namespace granary::pbm
