// granary serve beside a real campaign: who is let in, and the page in a real browser.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <fstream>
#include <memory>
#include <optional>

#include "pilot/launch/command.hpp"
#include "tests/support/background.hpp"
#include "tests/support/browser.hpp"
#include "tests/support/granary_program.hpp"

namespace granary {
namespace {

using test::Background;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// A connection to a port of ours.
class Client {
 public:
  explicit Client(int port) : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~Client() { close(fd_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  bool connected() const { return connected_; }
  void send(const std::string& text) const { (void)!::send(fd_, text.data(), text.size(), MSG_NOSIGNAL); }
  /// What comes until `text` is in it, the other side closes, or `seconds` are over.
  std::string read_until(const std::string& text, double seconds = 5.0) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (text.empty() || in_.find(text) == std::string::npos) {
      const double left = std::chrono::duration<double>(until - std::chrono::steady_clock::now()).count();
      pollfd readable{fd_, POLLIN, 0};
      char buffer[65536];
      if (left <= 0.0 || poll(&readable, 1, static_cast<int>(left * 1e3) + 1) <= 0) break;
      const ssize_t n = recv(fd_, buffer, sizeof buffer, 0);
      if (n <= 0) break;
      in_.append(buffer, static_cast<std::size_t>(n));
    }
    return in_;
  }
  void forget() { in_.clear(); }

 private:
  int fd_;
  bool connected_ = false;
  std::string in_;
};

class Serve : public ::testing::Test {
 protected:
  test::Scratch scratch;
  std::string dir = (scratch / "run").string();
  std::unique_ptr<Background> campaign, server;
  std::string url;
  int port = 0;

  void begin() {
    const auto file = (scratch / "workflow.json").string();
    std::ofstream(file) << R"({"granary": 1, "kind": "tasks", "name": "served", "tasks": [
      {"name": "the-long-one", "command": ["sleep", "60"]},
      {"name": "the-short-one", "command": ["sleep", "2.5"]}]})";
    campaign = std::make_unique<Background>(
        std::vector<std::string>{test::kGranary, "run", file, "--dir", dir, "--cores", "2", "--quiet"});
    for (int tries = 0; tries < 100 && test::granary({"explain", dir, "the-long-one"}).exit_code != 0; ++tries)
      usleep(20'000);
    server = std::make_unique<Background>(std::vector<std::string>{test::kGranary, "serve", dir});
    ASSERT_TRUE(server->says("\n")) << "the address is printed";
    url = server->output().substr(0, server->output().find('\n'));
    ASSERT_THAT(url, StartsWith("http://127.0.0.1:"));
    port = std::atoi(url.c_str() + std::string("http://127.0.0.1:").size());
  }
  void TearDown() override {
    if (!campaign) return;
    test::granary({"stop", dir});
    EXPECT_EQ(4, campaign->exit_code());
  }
  std::string path() const { return url.substr(url.find('/', 8)); }
  std::string get(const std::string& path, const std::string& host = "127.0.0.1",
                  const std::string& method = "GET") const {
    Client client(port);
    client.send(method + " " + path + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
    return client.read_until("");
  }
};

TEST_F(Serve, LetsInTheTokenAndItsOwnHostAndNothingElse) {
  ASSERT_NO_FATAL_FAILURE(begin());

  const std::string page = get(path());
  EXPECT_THAT(page, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'; script-src 'self'"));
  EXPECT_THAT(page, HasSubstr("Referrer-Policy: no-referrer"));
  EXPECT_THAT(get(path() + "page.js") + get(path() + "page.css") + page, Not(HasSubstr("https://")))
      << "nothing from elsewhere";
  EXPECT_THAT(get(path() + "view.json"), HasSubstr("\"name\":\"the-long-one\""));

  std::string wrong = path();
  wrong[5] = wrong[5] == '0' ? '1' : '0';
  EXPECT_THAT(get(wrong), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(get(path(), "evil.example:" + std::to_string(port)), StartsWith("HTTP/1.1 421")) << "DNS rebinding";
  EXPECT_THAT(get(path(), "127.0.0.1", "POST"), StartsWith("HTTP/1.1 405"));
  EXPECT_THAT(get(path() + "journal.jsonl"), StartsWith("HTTP/1.1 404"));
  EXPECT_EQ("", get("/" + std::string(20000, 'x'))) << "a header of 20 KB is not read";
}

TEST_F(Serve, RefusesMoreThan32ConnectionsAndTakesNewOnesWhenTheyHaveGone) {
  ASSERT_NO_FATAL_FAILURE(begin());
  std::vector<std::unique_ptr<Client>> held;
  for (int k = 0; k < 32; ++k) {
    held.push_back(std::make_unique<Client>(port));
    held.back()->send("GET " + path() + "events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    ASSERT_THAT(held.back()->read_until("event: view"), HasSubstr("text/event-stream")) << k;
  }

  Client one_more(port);
  EXPECT_THAT(one_more.read_until(""), StartsWith("HTTP/1.1 503"));

  held[0]->forget();
  EXPECT_THAT(held[0]->read_until("event: view"), HasSubstr("event: view")) << "the others are still told";
  held.clear();
  std::string page;  // once the server has seen them go
  for (int tries = 0; tries < 40 && !page.starts_with("HTTP/1.1 200"); ++tries, usleep(50'000)) page = get(path());
  EXPECT_THAT(page, StartsWith("HTTP/1.1 200"));
}

TEST_F(Serve, EndsWithCtrlCAndLeavesTheCampaignAlone) {
  ASSERT_NO_FATAL_FAILURE(begin());
  Client reader(port);
  reader.send("GET " + path() + "events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  ASSERT_THAT(reader.read_until("event: view"), HasSubstr("the-long-one"));

  server->signal(SIGINT);

  EXPECT_EQ(0, server->exit_code(3.0));
  EXPECT_FALSE(Client(port).connected());
  EXPECT_TRUE(test::granary_json({"status", dir, "--json"})["alive"].as_bool());
}

TEST_F(Serve, ShowsTheTasksInABrowserAndTellsItWhatChanges) {
  const char* search = std::getenv("PATH");
  if (!pilot::find_executable("chromium", "", search != nullptr ? search : ""))
    GTEST_SKIP() << "chromium is not installed";
  ASSERT_NO_FATAL_FAILURE(begin());

  test::Browser browser((scratch / "browser").string(), url);
  ASSERT_TRUE(browser.open());

  EXPECT_TRUE(browser.becomes("document.querySelector('#tasks').innerText.includes('the-long-one')"));
  EXPECT_TRUE(browser.becomes("document.querySelector('#happenings').innerText.includes('the-short-one finished')"))
      << "it happened after the page was loaded";
  EXPECT_TRUE(browser.becomes("Number(document.querySelector('#updates').textContent) >= 3")) << "server-sent events";
  EXPECT_EQ("running", browser.value("document.querySelector('#phase').textContent"));
  EXPECT_EQ("served", browser.value("document.querySelector('#campaign').textContent"));
  EXPECT_EQ("true", browser.value("document.querySelectorAll('#cores svg path.fill').length > 0")) << "cores over time";
  EXPECT_EQ("true", browser.value("performance.getEntriesByType('resource').every("
                                  "one => one.name.startsWith(location.href) || one.name.startsWith('data:'))"))
      << "nothing from elsewhere";

  server->signal(SIGINT);
  EXPECT_EQ(0, server->exit_code(3.0));
  EXPECT_TRUE(browser.becomes("document.querySelector('#link').textContent.includes('lost')")) << "and it says so";
}

}  // namespace
}  // namespace granary
