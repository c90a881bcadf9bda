// Campaigns as jobs of a real Slurm of three virtual nodes, and what goes wrong there.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include "tests/support/agent_tasks.hpp"
#include "tests/support/granary_program.hpp"
#include "tests/support/slurm_cluster.hpp"

namespace granary::test {
namespace {

using ::testing::HasSubstr;

class Slurm : public ::testing::Test {
 protected:
  static SlurmCluster* cluster;
  static void SetUpTestSuite() { cluster = new SlurmCluster(3, 2); }
  static void TearDownTestSuite() {
    delete cluster;
    cluster = nullptr;
  }

  void SetUp() override {
    if (!cluster->why_not().empty()) GTEST_SKIP() << "Slurm cannot be started here: " << cluster->why_not();
    scratch.emplace();
  }
  void TearDown() override {
    if (!scratch || !HasFailure()) return;
    for (const auto& entry : fs::recursive_directory_iterator(scratch->path()))
      if (entry.path().filename().string().starts_with("slurm-"))
        std::printf("%s:\n%s\n", entry.path().c_str(), text_in(entry.path()).c_str());
  }

  fs::path dir(const char* name = "run") const { return *scratch / name; }
  static json::Value nodes(int count) {
    return json::Value::object({{"nodes", count}, {"walltime", "10 min"}, {"stop_before", "1 min"}});
  }
  void submit(json::Value resources, json::Value tasks, const char* name = "run") const {
    const fs::path file =
        write_workflow(*scratch / (std::string(name) + ".json"), name, std::move(resources), std::move(tasks));
    const auto output = granary({"submit", file.string(), "--dir", dir(name).string()});
    ASSERT_EQ(output.exit_code, 0) << output.err;
    EXPECT_THAT(output.out, HasSubstr("job "));
  }
  static json::Value status_of(const fs::path& run) { return granary_json({"status", run.string(), "--json"}); }
  static std::int64_t finished_in(const fs::path& run) {
    const auto output = granary({"status", run.string(), "--json"});
    const auto status = json::parse(output.out, "status");  // none, if the pilot just went
    return output.exit_code == 0 && status ? (*status)["counts"].integer_or("finished", 0) : 0;
  }
  void wait_for_finished(int count, double seconds, const char* name = "run") const {
    EXPECT_TRUE(wait_until([&] { return finished_in(dir(name)) >= count; }, seconds)) << finished_in(dir(name));
  }
  bool has_begun(const std::string& task) const { return !text_in(dir() / (task + ".log")).empty(); }

  std::optional<Scratch> scratch;
};

SlurmCluster* Slurm::cluster = nullptr;

TEST_F(Slurm, ShowsTheScriptOfAJobAndSubmitsNothing) {
  json::Value resources = nodes(3);
  resources.set("partition", "main").set("account", "drums").set("options", std::vector<std::string>{"--nice=5"});
  const fs::path file = write_workflow(*scratch / "w.json", "w", resources, honest_tasks(1, 0.0));
  const auto output = granary({"submit", file.string(), "--dir", (*scratch / "it's here").string(), "--dry-run"});

  EXPECT_EQ(output.exit_code, 0) << output.err;
  for (const char* line : {"--nodes=3\n", "--partition=main\n", "--account=drums\n", "--time=00:10:00\n", "--nice=5\n",
                           "--signal=B:USR1@60\n", "--no-kill\n", "--no-requeue\n"})
    EXPECT_THAT(output.out, HasSubstr(std::string("#SBATCH ") + line));
  EXPECT_THAT(output.out, HasSubstr("it'\\''s here' --quiet\n"));
  EXPECT_FALSE(fs::exists(*scratch / "it's here"));
}

TEST_F(Slurm, RefusesWhatWouldBeMoreThanAnOption) {
  json::Value resources = nodes(1);
  resources.set("partition", "main\nrm -rf /").set("options", std::vector<std::string>{"--wrap=ls"});
  const fs::path file = write_workflow(*scratch / "w.json", "w", resources, honest_tasks(1, 0.0));
  const auto output = granary({"submit", file.string(), "--dry-run"});

  EXPECT_EQ(output.exit_code, 2);
  EXPECT_THAT(output.err, HasSubstr("/resources/partition"));
  EXPECT_THAT(output.err, HasSubstr("\"--wrap=ls\" is set by granary itself"));
}

TEST_F(Slurm, RunsTwoCampaignsAtOnceEachAsOneJobAndAnswersFromTheLoginNode) {
  json::Value tasks = honest_tasks(24, 0.4);
  tasks.push(honest_mpi_task("mpi", 0.2));
  submit(nodes(2), tasks, "two");
  submit(nodes(1), honest_tasks(12, 0.4), "one");
  wait_for_finished(1, 15.0, "two");

  if (cluster->has_own_hosts()) {
    // From here the pilot's node is another host: its control socket would be of no use.
    EXPECT_THAT(json::read_file(dir("two") / "endpoint.json")->text_or("host", ""), ::testing::StartsWith("node"));
    fs::remove(dir("two") / "control.sock");
  }
  EXPECT_TRUE(status_of(dir("two"))["alive"].as_bool());
  EXPECT_THAT(granary({"explain", dir("two").string(), "t0"}).out, HasSubstr("t0"));
  wait_for_finished(25, 30.0, "two");
  wait_for_finished(12, 30.0, "one");

  expect_each_finished_once(dir("two"), 24);
  expect_each_finished_once(dir("one"), 12);
  const std::string hosts = text_in(dir("two") / "mpi.hosts");
  EXPECT_EQ(count_in(hosts, "\n"), 2) << hosts;
  if (cluster->has_own_hosts()) {
    EXPECT_NE(hosts.substr(0, hosts.size() / 2), hosts.substr(hosts.size() / 2)) << "on two nodes";
  }
  cluster->wait_until_idle();
}

TEST_F(Slurm, StopsFromTheLoginNodeAndGoesOnWithAnotherJob) {
  submit(nodes(2), honest_tasks(20, 0.4));
  wait_for_finished(4, 20.0);
  EXPECT_EQ(granary({"stop", dir().string()}).exit_code, 0);
  cluster->wait_until_idle();
  const auto before = finished_in(dir());
  EXPECT_LT(before, 20);
  EXPECT_EQ(processes_of_tasks(dir()), 0);

  EXPECT_EQ(granary({"submit", dir().string()}).exit_code, 0);
  EXPECT_THAT(granary({"submit", dir().string()}).err,
              ::testing::AnyOf(HasSubstr("in the queue already"), HasSubstr("running")));
  wait_for_finished(20, 30.0);

  expect_each_finished_once(dir(), 20);
  cluster->wait_until_idle();
}

TEST_F(Slurm, LosesOnlyWhatRanThereWhenAnAgentIsKilledAndEndsItsOrphans) {
  submit(nodes(3), honest_tasks(36, 0.6));
  wait_for_finished(6, 20.0);
  const AgentPids first = agent_of(dir(), "node2"), second = agent_of(dir(), "node3");
  ASSERT_TRUE(first.worker > 0 && second.worker > 0 && second.guardian > 0);
  kill(first.worker, SIGKILL);
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  kill(second.guardian, SIGKILL);
  kill(second.worker, SIGKILL);
  wait_for_finished(36, 30.0);

  expect_each_finished_once(dir(), 36);
  EXPECT_EQ(times_of(dir(), "node.lost").size(), 2u);
  EXPECT_EQ(times_of(dir(), "node.back").size(), 2u) << "both nodes are used again";
  EXPECT_LE(times_of(dir(), "task.lost").size(), 4u);
  cluster->wait_until_idle();
  EXPECT_EQ(processes_of_tasks(dir()), 0);
}

TEST_F(Slurm, StopsInTimeBeforeTheWalltimeAndTheNextJobGoesOn) {
  // Slurm looks at walltimes every 30 s: the signal comes within the first half minute. The first attempt works until
  // it is stopped, the second one goes on where it was.
  const char* const script =
      "n=$(cat n 2>/dev/null || echo 0); trap 'echo stopped at $n >> log; exit 0' USR1; "
      "while [ $GRANARY_ATTEMPT = 1 -a $n -lt 500 ]; do n=$((n+1)); echo $n > n; sleep 0.1; done; "
      "echo went on at $n >> log";
  json::Value tasks = honest_tasks(4, 0.1);
  tasks.push(json::Value::object({{"name", "long"},
                                  {"dir", "long"},
                                  {"resumable", true},
                                  {"stop", json::Value::object({{"signal", "SIGUSR1"}, {"grace", "5 s"}})},
                                  {"command", std::vector<std::string>{"/bin/sh", "-c", script}}}));
  submit(json::Value::object({{"nodes", 1}, {"walltime", "1 min"}, {"stop_before", "56 s"}, {"chain", 1}}), tasks);
  ASSERT_TRUE(wait_until([&] { return text_in(dir() / "long/log").find("went on") != std::string::npos; }, 70.0));
  cluster->wait_until_idle();

  expect_each_finished_once(dir(), 4);
  const std::string n = text_in(dir() / "long/n"), at = n.substr(0, n.find('\n'));
  EXPECT_EQ(text_in(dir() / "long/log"), "stopped at " + at + "\nwent on at " + at + "\n");
  EXPECT_EQ(count_in(text_in(dir() / "jobs.jsonl"), "\"chained\":true"), 1);
  EXPECT_EQ(times_of(dir(), "pilot.open").size(), 2u);
  EXPECT_EQ(times_of(dir(), "pilot.close").size(), 2u) << "both pilots ended gracefully";
  EXPECT_EQ(finished_in(dir()), 5);
}

TEST_F(Slurm, NoticesAPowerCutWithinFiveSecondsAndRunsTheRestElsewhere) {
  json::Value tasks = honest_tasks(24, 1.0);
  tasks.push(honest_mpi_task("mpi", 3.0));
  submit(nodes(3), tasks);
  ASSERT_TRUE(wait_until([&] { return has_begun("mpi"); }, 20.0));
  const double cut = wall_now();
  cluster->crash("node2");
  wait_for_finished(25, 60.0);

  const auto lost = times_of(dir(), "node.lost");
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_LE(lost[0] - cut, 5.0);
  RecordProperty("noticed_after_s", std::to_string(lost[0] - cut));
  expect_each_finished_once(dir(), 24);
  EXPECT_EQ(count_in(text_in(dir() / "mpi.log"), "done"), 1) << text_in(dir() / "mpi.log");
  EXPECT_GE(count_in(text_in(dir() / "mpi.log"), "begin"), 1);
  cluster->boot("node2");
  cluster->wait_until_idle();
}

TEST_F(Slurm, BeginsWithoutANodeThatIsDeadAlreadyAndSaysSo) {
  cluster->crash("node3");
  submit(nodes(3), honest_tasks(8, 0.5));
  wait_for_finished(8, 60.0);

  const auto lost = times_of(dir(), "node.lost");
  ASSERT_EQ(lost.size(), 1u);
  struct stat secret = {};  // made just before the agents are started
  ASSERT_EQ(stat((dir() / "secret").c_str(), &secret), 0);
  const double asked = static_cast<double>(secret.st_mtim.tv_sec) + 1e-9 * static_cast<double>(secret.st_mtim.tv_nsec);
  EXPECT_LE(lost[0] - asked, 8.0) << "Slurm itself gives up after 11 s, and ends the agents of the step with it";
  RecordProperty("done_without_after_s", std::to_string(lost[0] - asked));
  expect_each_finished_once(dir(), 8);
  cluster->boot("node3");
  cluster->wait_until_idle();
}

}  // namespace
}  // namespace granary::test
