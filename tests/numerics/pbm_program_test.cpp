// granary-pbm as a program: restart to the bit, ranks, signals, and what bad input gets.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "common/json/io.hpp"
#include "common/results/hdf5_file.hpp"
#include "tests/support/pbm_cases.hpp"

namespace granary::pbm {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const std::string kProgram = std::string(GRANARY_BIN_DIR) + "/granary-pbm";

struct Ended {
  int exit = -1;
  std::string out, err;
};

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

class PbmProgram : public ::testing::Test {
 protected:
  PbmProgram() {
    folder_ = fs::temp_directory_path() / ("granary-pbm-test-" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~PbmProgram() override { fs::remove_all(folder_); }

  fs::path write_case(const std::string& name, const PbmCase& c) {
    const fs::path file = folder_ / name;
    EXPECT_TRUE(json::write_file(file, to_json(c)));
    return file;
  }
  /// A folder for a run, so that each has its own progress.jsonl and checkpoint.h5.
  fs::path out(const std::string& run) {
    fs::create_directories(folder_ / run);
    return folder_ / run / "out.h5";
  }
  pid_t start(std::vector<std::string> arguments, rlim_t largest_file = RLIM_INFINITY) {
    const pid_t child = fork();
    if (child != 0) return child;
    if (largest_file != RLIM_INFINITY) {
      const rlimit limit{largest_file, largest_file};
      setrlimit(RLIMIT_FSIZE, &limit);
    }
    dup2(open((folder_ / "stdout").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), 1);
    dup2(open((folder_ / "stderr").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), 2);
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  Ended wait_for(pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), text_of(folder_ / "stdout"),
            text_of(folder_ / "stderr")};
  }
  Ended run(const fs::path& case_file, const fs::path& file, int threads = 1, int ranks = 1) {
    std::vector<std::string> command;
    if (ranks > 1)
      command = {"mpirun",
                 "--allow-run-as-root",
                 "--oversubscribe",
                 "--bind-to",
                 "none",
                 "--mca",
                 "pml",
                 "ob1",
                 "--mca",
                 "btl",
                 "self,vader",
                 "-np",
                 std::to_string(ranks)};
    for (const std::string& word : {kProgram, std::string("run"), case_file.string(), std::string("--out"),
                                    file.string(), std::string("--threads"), std::to_string(threads)})
      command.push_back(word);
    return wait_for(start(command));
  }

  fs::path folder_;
};

/// The rows of `part` hold the bits that `whole` has at the same times.
void expect_same_states(const fs::path& whole, const fs::path& part, std::size_t at_least) {
  const auto a = Hdf5File::open(whole), b = Hdf5File::open(part);
  ASSERT_TRUE(a && b);
  const auto times_a = a->read("/state/time"), times_b = b->read("/state/time");
  ASSERT_TRUE(times_a && times_b);
  std::size_t compared = 0;
  for (std::size_t row_b = 0; row_b < times_b->values.size(); ++row_b)
    for (std::size_t row_a = 0; row_a < times_a->values.size(); ++row_a) {
      if (times_a->values[row_a] != times_b->values[row_b]) continue;
      ++compared;
      for (const char* name :
           {"/state/number", "/state/liquid", "/state/gas", "/state/ledger", "/state/next_step", "/state/last_error"}) {
        const auto x = a->read_row(name, row_a), y = b->read_row(name, row_b);
        ASSERT_TRUE(x && y);
        EXPECT_TRUE(*x == *y) << name << " differs at " << times_b->values[row_b] << " s";
      }
    }
  EXPECT_GE(compared, at_least);
}

PbmCase a_short_case() {
  PbmCase c = testing::a_granulator(8, 3);
  c.spray->start = 0.33;
  c.end_time = 2.0;
  return c;
}

TEST_F(PbmProgram, GoesOnFromAnyOutputTimeWithTheSameBits) {
  const PbmCase whole = a_short_case();
  ASSERT_EQ(run(write_case("whole.json", whole), out("whole")).exit, 0);
  PbmCase first = whole;
  first.end_time = 1.0;
  ASSERT_EQ(run(write_case("first.json", first), out("first")).exit, 0);

  for (const double from : {0.2, 0.6, 1.0}) {
    PbmCase second = whole;
    second.restart = Restart{out("first"), from};
    const Ended ended = run(write_case("second.json", second), out("second"), 2);
    ASSERT_EQ(ended.exit, 0) << ended.err;
    expect_same_states(out("whole"), out("second"), static_cast<std::size_t>(std::lround((2.0 - from) / 0.2)));
  }
}

class PbmCheckpoint : public PbmProgram {
 protected:
  static PbmCase a_long_case() {
    PbmCase c = testing::a_granulator(12, 3);
    c.end_time = 12.0;
    c.aggregation->rate = 3.0;
    return c;
  }
  /// Runs `whole` until a signal ends it, and the rest of it from the checkpoint.
  void stop_and_go_on(const PbmCase& whole, int signal) {
    const fs::path stopped = out("stopped"), progress = stopped.parent_path() / "progress.jsonl";
    fs::remove(progress);
    const pid_t child =
        start({kProgram, "run", write_case("stopped.json", whole).string(), "--out", stopped.string(), "--json"});
    const auto lines = [&] {
      const std::string text = text_of(progress);
      return std::count(text.begin(), text.end(), '\n');
    };
    for (int wait = 0; wait < 4000 && lines() < 12; ++wait) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    kill(child, signal);
    const Ended ended = wait_for(child);
    ASSERT_EQ(ended.exit, 0) << ended.err;
    const auto report = json::parse(ended.out, "stdout");
    ASSERT_TRUE(report) << ended.out;
    ASSERT_EQ((*report)["ended"].as_string(), "stopped") << "it was done before the signal came; make the case longer";

    PbmCase rest = whole;
    rest.restart = Restart{stopped.parent_path() / "checkpoint.h5", {}};
    ASSERT_EQ(run(write_case("rest.json", rest), out("rest"), 2).exit, 0);
  }
};

TEST_F(PbmCheckpoint, GoesOnWithTheSameBitsWhereNoKernelIsReused) {
  PbmCase whole = a_long_case();
  whole.kernel_tolerance = 0.0;
  ASSERT_EQ(run(write_case("whole.json", whole), out("whole")).exit, 0);

  for (const int signal : {SIGTERM, SIGUSR1}) {
    stop_and_go_on(whole, signal);
    expect_same_states(out("whole"), out("rest"), 2);
  }
}

// Between outputs a run has kernels of an earlier state, a restart those of the checkpoint: as near to each other as
// kernel_tolerance says.
TEST_F(PbmCheckpoint, GoesOnWithinTheToleranceWhereKernelsAreReused) {
  const PbmCase whole = a_long_case();
  ASSERT_EQ(run(write_case("whole.json", whole), out("whole")).exit, 0);

  stop_and_go_on(whole, SIGTERM);

  const auto a = Hdf5File::open(out("whole")), b = Hdf5File::open(out("rest"));
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->read("/state/time")->values.back(), b->read("/state/time")->values.back());
  for (const char* name : {"/state/number", "/state/liquid", "/state/gas"}) {
    const auto x = a->read(name), y = b->read(name);
    ASSERT_TRUE(x && y);
    const std::size_t n = x->values.size() / x->shape[0];
    double off = 0.0, sum = 0.0;
    for (std::size_t k = 1; k <= n; ++k) {
      off += std::abs(x->values[x->values.size() - k] - y->values[y->values.size() - k]);
      sum += x->values[x->values.size() - k];
    }
    EXPECT_LT(off, 2.0 * whole.kernel_tolerance * sum) << name;
  }
}

#ifdef GRANARY_TEST_WITH_MPI
TEST_F(PbmProgram, GivesTheSameBitsOnAnyNumberOfRanks) {
  const fs::path file = write_case("case.json", a_short_case());
  ASSERT_EQ(run(file, out("one")).exit, 0);

  for (const int ranks : {2, 3}) {
    const Ended ended = run(file, out("more"), ranks == 2 ? 2 : 1, ranks);
    ASSERT_EQ(ended.exit, 0) << ended.err;
    expect_same_states(out("one"), out("more"), 11);
  }
}

// Breakage so fast that steps are implicit; 12 compartments are 8 + 4 lanes on one rank, 6 on each of two, 4 of three.
TEST_F(PbmProgram, GivesTheSameBitsOnAnyNumberOfRanksWhereStepsAreImplicit) {
  PbmCase c = testing::a_granulator(7, 12);
  c.breakage->rate = 1e4;
  c.end_time = 0.8;
  const fs::path file = write_case("case.json", c);
  ASSERT_EQ(run(file, out("one")).exit, 0);

  for (const int ranks : {2, 3}) {
    const Ended ended = run(file, out("more"), 1, ranks);
    ASSERT_EQ(ended.exit, 0) << ended.err;
    expect_same_states(out("one"), out("more"), 5);
  }
}

TEST_F(PbmProgram, GoesOnWithAnotherNumberOfRanks) {
  const PbmCase whole = a_short_case();
  ASSERT_EQ(run(write_case("whole.json", whole), out("whole")).exit, 0);
  PbmCase second = whole;
  second.restart = Restart{out("whole"), 0.8};

  ASSERT_EQ(run(write_case("second.json", second), out("second"), 1, 2).exit, 0);

  expect_same_states(out("whole"), out("second"), 7);
}

TEST_F(PbmProgram, RefusesMoreRanksThanCompartments) {
  const Ended ended = run(write_case("case.json", a_short_case()), out("run"), 1, 4);

  EXPECT_EQ(ended.exit, 2);
  EXPECT_THAT(ended.err, HasSubstr("4 ranks for 3 compartments"));
}
#endif

TEST_F(PbmProgram, WritesALineAndARowForEveryOutput) {
  const PbmCase c = a_short_case();

  const Ended ended = run(write_case("case.json", c), out("run"));

  ASSERT_EQ(ended.exit, 0) << ended.err;
  const auto lines = json::read_lines(out("run").parent_path() / "progress.jsonl");
  ASSERT_TRUE(lines);
  ASSERT_EQ(lines->size(), 12u);  // header, start, 0.2 .. 2.0
  EXPECT_EQ((*lines)[0]["format"].as_string(), "granary-progress-1");
  const json::Value& last = lines->back();
  EXPECT_EQ(last["time_s"].as_number(), 2.0);
  EXPECT_EQ(last["d50_m"].size(), 3u);
  for (const char* quantity : {"solid_1", "solid_2", "liquid", "gas"})
    EXPECT_LT(last["drift"][quantity].as_number(), 1e-12);
  const auto h5 = Hdf5File::open(out("run"));
  ASSERT_TRUE(h5);
  EXPECT_EQ(*h5->text_attribute("/", "format"), "granary-pbm-out-1");
  EXPECT_EQ(*h5->text_attribute("/", "case"), json::dump(to_json(c)));
  EXPECT_THAT(h5->read("/state/number")->shape, ::testing::ElementsAre(11, 3, 8, 8));
  EXPECT_THAT(h5->read("/outlet/number_rate")->shape, ::testing::ElementsAre(11, 8, 8));
  EXPECT_EQ(h5->read("/state/d50")->values.back(), last["d50_m"].numbers().back());
}

TEST_F(PbmProgram, TakesChangedRatesOnARestart) {
  PbmCase c = a_short_case();
  ASSERT_EQ(run(write_case("case.json", c), out("first")).exit, 0);
  for (auto& row : c.dem->collision_rate)
    for (double& rate : row) rate *= 50.0;
  c.feed->classes.resize(2);
  c.restart = Restart{out("first"), {}};
  c.end_time = 3.0;

  const Ended ended = run(write_case("case.json", c), out("second"));

  EXPECT_EQ(ended.exit, 0) << ended.err;
}

TEST_F(PbmProgram, RefusesTheStateOfAnotherGridNamingBoth) {
  PbmCase c = a_short_case();
  ASSERT_EQ(run(write_case("case.json", c), out("first")).exit, 0);
  c.restart = Restart{out("first"), {}};
  c.end_time = 3.0;
  c.grid.bins = {9, 8};

  const Ended ended = run(write_case("case.json", c), out("second"));

  EXPECT_EQ(ended.exit, 2);
  EXPECT_THAT(ended.err, HasSubstr("8 classes"));
  EXPECT_THAT(ended.err, HasSubstr("9 classes"));
  EXPECT_THAT(ended.err, HasSubstr(out("first").string()));
}

TEST_F(PbmProgram, RefusesARestartItCannotBegin) {
  PbmCase c = a_short_case();
  ASSERT_EQ(run(write_case("case.json", c), out("first")).exit, 0);

  c.restart = Restart{out("first"), 0.5};
  Ended ended = run(write_case("case.json", c), out("second"));
  EXPECT_EQ(ended.exit, 2);
  EXPECT_THAT(ended.err, HasSubstr("no state at 0.5 s"));

  c.restart = Restart{out("first"), {}};
  ended = run(write_case("case.json", c), out("second"));
  EXPECT_EQ(ended.exit, 2);
  EXPECT_THAT(ended.err, HasSubstr("/end_time"));

  c.end_time = 3.0;
  ended = run(write_case("case.json", c), out("first"));
  EXPECT_EQ(ended.exit, 2);
  EXPECT_THAT(ended.err, HasSubstr("would be lost"));

  c.restart = Restart{folder_ / "nowhere.h5", {}};
  ended = run(write_case("case.json", c), out("second"));
  EXPECT_EQ(ended.exit, 2);
  EXPECT_THAT(ended.err, HasSubstr("nowhere.h5"));
}

TEST_F(PbmProgram, EndsWith2ForABadCaseAndABadCommand) {
  PbmCase c = a_short_case();
  c.relative_tolerance = 7.0;

  const Ended bad_case = run(write_case("case.json", c), out("run"));
  EXPECT_EQ(bad_case.exit, 2);
  EXPECT_THAT(bad_case.err, HasSubstr("/relative_tolerance is 7"));

  EXPECT_EQ(run(folder_ / "missing.json", out("run")).exit, 2);
  EXPECT_EQ(wait_for(start({kProgram, "walk"})).exit, 2);
  EXPECT_EQ(wait_for(start({kProgram, "--help"})).exit, 0);
}

TEST_F(PbmProgram, EndsWith20WhenItCannotKeepItsTolerance) {
  PbmCase c = testing::a_case(8);
  c.aggregation = Aggregation{};
  c.aggregation->rate = 1e30;
  c.initial = {{0, 0, 0, 1e10, 0.0, 0.0}};

  const Ended ended = run(write_case("case.json", c), out("run"));

  EXPECT_EQ(ended.exit, 20);
  EXPECT_THAT(ended.err, HasSubstr("/relative_tolerance"));
}

TEST_F(PbmProgram, SaysThatTheDiskIsFullAndKeepsTheStatesBefore) {
  PbmCase c = testing::a_granulator(16, 4);
  c.end_time = 10.0;
  const fs::path file = out("run");

  const Ended ended =
      wait_for(start({kProgram, "run", write_case("case.json", c).string(), "--out", file.string()}, 900 * 1024));

  EXPECT_EQ(ended.exit, 3);
  EXPECT_THAT(ended.err, HasSubstr("the disk is full"));
  const auto h5 = Hdf5File::open(file);
  ASSERT_TRUE(h5);
  EXPECT_GT(h5->read("/state/time")->values.size(), 3u);
  c.restart = Restart{file, {}};
  EXPECT_EQ(run(write_case("case.json", c), out("rest")).exit, 0);
}

TEST_F(PbmProgram, VerifiesItself) {
  const Ended ended = wait_for(start({kProgram, "verify", "sum-1d", "--bins", "40", "--json"}));

  ASSERT_EQ(ended.exit, 0) << ended.err;
  const auto document = json::parse(ended.out, "stdout");
  ASSERT_TRUE(document);
  const json::Value& one = (*document)["cases"].items()[0];
  EXPECT_LT(one["l1_number"].as_number(), 0.0265);
  EXPECT_EQ(one["bins"].as_integer(), 40);
  EXPECT_TRUE(one["passed"].as_bool());
  EXPECT_LT(one["drift"]["solid_1"].as_number(), 1e-13);
  EXPECT_LT(std::abs(one["moment_errors"]["M00"].as_number()), 2e-5);
  EXPECT_GT(one["rhs_evaluations"].as_integer(), 0);
  for (const char* key : {"name", "order", "cpu_s"}) EXPECT_NE(one.find(key), nullptr) << key;
  EXPECT_EQ(wait_for(start({kProgram, "verify", "sum-3d"})).exit, 2);
}

}  // namespace
}  // namespace granary::pbm
