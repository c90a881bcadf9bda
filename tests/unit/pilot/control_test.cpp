// Who is answered on the control socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "common/log.hpp"
#include "pilot/control/control.hpp"

namespace granary::pilot {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr uid_t kNobody = 65534;

class Control : public ::testing::Test {
 protected:
  fs::path dir = fs::temp_directory_path() / ("granary_control_" + std::to_string(getpid()));
  RealLoop loop;
  int answered = 0;

  void SetUp() override {
    log::set_level(log::Level::off);
    fs::create_directories(dir);
    chmod(dir.c_str(), 0755);
  }
  void TearDown() override { fs::remove_all(dir); }

  /// Whether a process of that user gets an answer while the server runs.
  bool is_answered(uid_t uid) {
    const int child = fork();
    if (child == 0) {
      if (uid != getuid() && setuid(uid) != 0) _exit(2);
      _exit(ask_pilot(dir, json::Value::object({{"ask", "status"}}), 2.0).has_value() ? 0 : 1);
    }
    int status = -1;
    std::function<void()> look = [&] {
      if (waitpid(child, &status, WNOHANG) == child) return loop.stop();
      loop.after(0.005, look);
    };
    look();
    loop.run();
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) != 2);
    return WEXITSTATUS(status) == 0;
  }

  Result<ControlServer> serve() {
    return ControlServer::listen(loop, dir, [this](const json::Value&) {
      ++answered;
      return json::Value::object({{"fine", true}});
    });
  }
};

TEST_F(Control, IsReadableByItsUserOnly) {
  const auto server = serve();
  ASSERT_TRUE(server.has_value());
  struct stat status = {};
  ASSERT_EQ(stat((dir / "control.sock").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  EXPECT_TRUE(is_answered(getuid()));
}

TEST_F(Control, AnswersNobodyElseEvenIfTheSocketIsOpenToAll) {
  if (getuid() != 0) GTEST_SKIP() << "only root can act as another user";
  const auto server = serve();
  ASSERT_TRUE(server.has_value());
  ASSERT_EQ(chmod((dir / "control.sock").c_str(), 0666), 0);

  EXPECT_FALSE(is_answered(kNobody));
  EXPECT_EQ(answered, 0) << "the request is not even read";
  EXPECT_TRUE(is_answered(0));
}

}  // namespace
}  // namespace granary::pilot
