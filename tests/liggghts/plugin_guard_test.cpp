// How granary-dem ends: the exit code tells what happened, a message on stderr tells the rest.
#include "tests/liggghts/plugin_deck.hpp"

namespace granary::dem::test {
namespace {

const std::string kGuard = "fix guard all granary/guard file tallies.jsonl every 1 ";

std::string head_on(double time_step, double speed, const std::string& more) {
  return head("-0.05 0.05 -0.02 0.02 -0.02 0.02") + physics(0.9, 0.0, time_step) +
         particles({{-0.01, 0, 0, speed, 0, 0, 0.004}, {0.01, 0, 0, -speed, 0, 0, 0.004}}) + more;
}

json::Value last_line(const Folder& folder) {
  const auto lines = json::read_lines(folder / "tallies.jsonl");
  return lines && !lines->empty() ? lines->back() : json::Value();
}

class GuardOn : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Ranks, GuardOn, testing::Values(1, 2));

TEST_P(GuardOn, EndsARunWhoseTimeStepIsAbsurd) {
  const Folder folder;
  EXPECT_EQ(run_deck(folder, head_on(2e-4, 8.0, kGuard + "\n" + tally(kOneBin, 5, 20) + "run 1000\n"), GetParam()), 20);

  const json::Value diverged = last_line(folder)["diverged"];
  EXPECT_EQ(diverged.text_or("cause", ""), "overlap");
  EXPECT_GT(diverged.number_or("value", 0), diverged.number_or("bound", 1));
  EXPECT_NE(folder.read("err").find("the run diverged"), std::string::npos);
  EXPECT_NE(folder.read("err").find("/dem/time_step"), std::string::npos);
}

TEST_P(GuardOn, EndsARunWhosePositionsAreNoNumbers) {
  const Folder folder;
  const std::string deck = head("-0.05 0.05 -0.02 0.02 -0.02 0.02") + physics() +
                           particles({{0, 0, 0, 0, 0, 0, 0.004}, {0, 0, 0, 0, 0, 0, 0.004}}) +  // a distance of 0
                           kGuard + "overlap 1000\n" + "run 100\n";
  EXPECT_EQ(run_deck(folder, deck, GetParam()), 20);
  EXPECT_EQ(last_line(folder)["diverged"].text_or("cause", ""), "nan");
}

TEST_P(GuardOn, EndsARunThatHasTooMuchEnergyOrLosesParticles) {
  const Folder folder;
  EXPECT_EQ(run_deck(folder, head_on(5e-6, 1.0, kGuard + "energy 1e-6\nrun 1000\n"), GetParam()), 20);
  EXPECT_EQ(last_line(folder)["diverged"].text_or("cause", ""), "energy");

  fs::remove(folder / "tallies.jsonl");
  EXPECT_EQ(run_deck(folder, head_on(5e-6, -10.0, kGuard + "lost 0.4\nrun 10000\n"), GetParam()), 20);  // they fly out
  EXPECT_EQ(last_line(folder)["diverged"].text_or("cause", ""), "lost");
  EXPECT_EQ(last_line(folder)["diverged"].number_or("value", 0), 1.0);
}

TEST_P(GuardOn, SaysWhichFileADiskIsFullFor) {
  const Folder folder;
  std::string deck = head_on(5e-6, 1.0, tally(kOneBin) + "run 100\n");
  deck.replace(deck.find("tallies.jsonl"), 13, "/dev/full");
  EXPECT_NE(run_deck(folder, deck, GetParam()), 0);
  EXPECT_NE(folder.read("err").find("/dev/full"), std::string::npos);
  EXPECT_NE(folder.read("err").find("No space left"), std::string::npos);
}

TEST_P(GuardOn, SaysThatTheStateCouldNotBeWritten) {
  const Folder folder;
  fs::create_directory(folder / "state.part");  // as good as a full disk: the file cannot be made
  EXPECT_EQ(run_deck(folder, head_on(5e-6, 1.0, kGuard + "restart state\nrun 100\n"), GetParam()), 3);
  EXPECT_NE(folder.read("err").find("the state cannot be written to state.part"), std::string::npos)
      << folder.read("err");

  fs::create_symlink("/dev/full", folder / "other.part");
  EXPECT_EQ(run_deck(folder, head_on(5e-6, 1.0, kGuard + "restart other\nrun 100\n"), GetParam()), 3);
  EXPECT_NE(folder.read("err").find("No space left"), std::string::npos) << folder.read("err");
  EXPECT_FALSE(fs::exists(folder / "other"));
}

TEST(GranaryDem, LeavesItsStateAfterAScriptThatRanToItsEnd) {
  const Folder folder;
  ASSERT_EQ(run_deck(folder, head_on(5e-6, 1.0, kGuard + "restart state\nrun 100\nwrite_restart by_script\n")), 0)
      << folder.read("err");
  EXPECT_EQ(folder.read("state").size(), folder.read("by_script").size());
  EXPECT_EQ(run_deck(folder, head("state") + physics() + kGuard + "\n" + tally(kOneBin, 5, 100) + "run 100\n"), 0)
      << folder.read("err");
  EXPECT_NEAR(last_line(folder).number_or("time_s", 0), 200 * 5e-6, 1e-12);
}

TEST_P(GuardOn, RefusesBadInputWithExitCode2) {
  const Folder folder;
  EXPECT_EQ(run_deck(folder, head_on(5e-6, 1.0, "fix t all granary/tally fiel x\n"), GetParam()), 2);
  EXPECT_NE(folder.read("err").find("did you mean 'file'?"), std::string::npos);

  EXPECT_EQ(run_deck(folder, head_on(5e-6, 1.0, tally(kOneBin + "body b mesh nowhere") + "run 10\n"), GetParam()), 2);
  EXPECT_NE(folder.read("err").find("no wall/gran fix uses a mesh 'nowhere'"), std::string::npos);

  EXPECT_EQ(run_deck(folder, "atom_style granular\nno_such_command\n", GetParam()), 2);
  EXPECT_NE(folder.read("err").find("no_such_command"), std::string::npos) << folder.read("err");
}

TEST(GranaryDem, NamesAnInputScriptThatIsNotThere) {
  const Folder folder;
  EXPECT_EQ(shell(folder, program() + " -in nowhere.liggghts"), 2);
  EXPECT_NE(folder.read("err").find("nowhere.liggghts"), std::string::npos) << folder.read("err");
}

// Starts the deck, waits until it has written a window, sends the signal; the exit code.
int stop_with(const Folder& folder, const std::string& signal, int ranks) {
  folder.write(
      "in.liggghts",
      head_on(5e-6, 0.01, kGuard + "restart state.liggghts\n" + tally(kOneBin, 5, 10000) + "run 2000000000\n"));
  return shell(folder, (ranks > 1 ? mpirun(ranks) : std::string("exec ")) + program() + " -in in.liggghts & p=$!; " +
                           "until [ \"$(cat tallies.jsonl 2> none | wc -l)\" -ge 2 ]; do sleep 0.05; done; " +
                           "kill -" + signal + " $p; wait $p");
}

TEST(GranaryDem, WritesItsStateAndEndsWith0WhenAskedToStop) {
  for (const auto& [signal, ranks] : std::vector<std::pair<std::string, int>>{{"TERM", 1}, {"USR1", 1}, {"USR1", 2}}) {
    const Folder folder;
    EXPECT_EQ(stop_with(folder, signal, ranks), 0) << signal << " " << folder.read("err");
    EXPECT_TRUE(fs::exists(folder / "state.liggghts"));

    const json::Value stopped = last_line(folder);
    fs::remove(folder / "tallies.jsonl");
    EXPECT_EQ(
        run_deck(folder, head("state.liggghts") + physics() + kGuard + "\n" + tally(kOneBin, 5, 100) + "run 100\n"), 0)
        << folder.read("err");
    EXPECT_NEAR(last_line(folder).number_or("time_s", 0), stopped.number_or("time_s", 9) + 100 * 5e-6, 1e-9);
  }
}

}  // namespace
}  // namespace granary::dem::test
