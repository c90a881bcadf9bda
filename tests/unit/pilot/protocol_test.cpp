// The protocol between pilot, agents and those who ask: frames, proofs, connections.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <optional>

#include "pilot/protocol/ask_remote.hpp"
#include "pilot/protocol/channel.hpp"
#include "pilot/protocol/endpoint.hpp"
#include "pilot/protocol/frame.hpp"
#include "pilot/protocol/handshake.hpp"
#include "pilot/protocol/listener.hpp"

namespace granary::pilot {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Digest key_of(unsigned char byte) {
  Digest key{};
  key.fill(byte);
  return key;
}

std::vector<std::string> all_of(FrameReader& reader) {
  std::vector<std::string> payloads;
  while (auto payload = reader.next()) payloads.push_back(*payload);
  return payloads;
}

TEST(Hmac, IsThatOfRfc4231) {
  Digest key{};
  std::fill_n(key.begin(), 20, 0x0b);  // case 1: a key shorter than the block is padded with zeros
  EXPECT_EQ(bytes_of(hmac(key, {"Hi ", "There"})).substr(0, 4), "\xb0\x34\x4c\x61");
}

TEST(Frames, ComeThroughHoweverTheBytesAreCut) {
  FrameWriter writer(key_of(1));
  const std::vector<std::string> sent{"one", "", std::string(70000, 'x')};
  std::string bytes;
  for (const std::string& payload : sent) bytes += writer.seal(payload);
  for (const std::size_t piece : {std::size_t{1}, std::size_t{7}, std::size_t{4096}, bytes.size()}) {
    FrameReader reader;
    reader.expect(key_of(1));
    std::vector<std::string> got;
    for (std::size_t at = 0; at < bytes.size(); at += piece) {
      reader.feed(std::string_view(bytes).substr(at, piece));
      for (const std::string& payload : all_of(reader)) got.push_back(payload);
    }

    EXPECT_TRUE(got == sent) << piece;
    EXPECT_EQ(reader.dropped(), 0);
  }
}

TEST(Frames, WithAnyByteChangedAreNeverTaken) {
  FrameWriter writer(key_of(1));
  const std::string whole = writer.seal("pay");
  for (std::size_t k = 0; k < whole.size(); ++k) {
    std::string changed = whole;
    changed[k] = static_cast<char>(changed[k] ^ 0x10);
    FrameReader reader;
    reader.expect(key_of(1));
    reader.feed(changed);

    EXPECT_THAT(all_of(reader), IsEmpty()) << "byte " << k;
  }
}

TEST(Frames, SealedWithAnotherKeyAreDroppedAndTheNextRightOneIsTaken) {
  FrameWriter writer(key_of(1)), stranger(key_of(2));
  FrameReader reader;
  reader.expect(key_of(1));
  reader.feed(stranger.seal("wrong"));
  reader.feed(writer.seal("right"));

  EXPECT_THAT(all_of(reader), ElementsAre("right"));
  EXPECT_EQ(reader.dropped(), 1);
  EXPECT_THAT(reader.last_dropped(), HasSubstr("seal is wrong"));
}

TEST(Frames, SentAgainAreDropped) {
  FrameWriter writer(key_of(1));
  const std::string first = writer.seal("first");
  FrameReader reader;
  reader.expect(key_of(1));
  const std::string second = writer.seal("second");
  reader.feed(first + first + second + first);

  EXPECT_THAT(all_of(reader), ElementsAre("first", "second"));
  EXPECT_EQ(reader.dropped(), 2);
  EXPECT_THAT(reader.last_dropped(), HasSubstr("message 1, which was here before"));
  EXPECT_THAT(reader.broken(), IsEmpty());
}

TEST(Frames, EndTheConnectionWhenOneIsMissingTooLongOrManyAreWrong) {
  FrameWriter writer(key_of(1)), stranger(key_of(2));
  FrameReader gap, length, many;
  for (FrameReader* reader : {&gap, &length, &many}) reader->expect(key_of(1));
  (void)writer.seal("lost");
  gap.feed(writer.seal("second"));
  length.feed(std::string("\x7f\xff\xff\xff", 4));
  for (int k = 0; k < FrameReader::kMostDropped; ++k) many.feed(stranger.seal("x"));
  for (FrameReader* reader : {&gap, &length, &many}) EXPECT_THAT(all_of(*reader), IsEmpty());

  EXPECT_THAT(gap.broken(), HasSubstr("message 2 came where 1 was to come"));
  EXPECT_THAT(length.broken(), HasSubstr("a frame of 2147483647 bytes"));
  EXPECT_THAT(many.broken(), HasSubstr("wrong or replayed"));
}

TEST(Handshake, GivesBothSidesTheSameKeysAndTellsThemApart) {
  Handshake caller = Handshake::call(key_of(7), Role::agent, "node1"), answerer = Handshake::answer(key_of(7));
  const std::string challenge = answerer.take(caller.first_message()).value();
  EXPECT_FALSE(answerer.done());
  const std::string proof = caller.take(challenge).value();
  EXPECT_EQ(answerer.take(proof).value(), "");

  EXPECT_TRUE(caller.done() && answerer.done());
  EXPECT_EQ(answerer.name(), "node1");
  EXPECT_EQ(answerer.role(), Role::agent);
  EXPECT_EQ(caller.key_to_answerer(), answerer.key_to_answerer());
  EXPECT_EQ(caller.key_to_caller(), answerer.key_to_caller());
  EXPECT_NE(caller.key_to_caller(), caller.key_to_answerer());
}

TEST(Handshake, RefusesWhoeverDoesNotKnowTheSecret) {
  Handshake right = Handshake::answer(key_of(7)), wrong = Handshake::answer(key_of(8));
  Handshake caller = Handshake::call(key_of(7), Role::client, "me"),
            thief = Handshake::call(key_of(8), Role::agent, "x");

  EXPECT_THAT(caller.take(*wrong.take(caller.first_message())).error().message, HasSubstr("does not know the secret"));
  const std::string challenge = right.take(thief.first_message()).value();
  EXPECT_FALSE(thief.take(challenge).has_value());
  EXPECT_THAT(right.take(std::string(32, 'x')).error().message, HasSubstr("does not know the secret"));
  EXPECT_FALSE(right.done());
}

TEST(Handshake, OfAnEarlierConnectionDoesNotOpenANewOne) {
  Handshake caller = Handshake::call(key_of(7), Role::agent, "node1"), first = Handshake::answer(key_of(7));
  const std::string hello = caller.first_message();
  const std::string proof = caller.take(*first.take(hello)).value();
  ASSERT_TRUE(first.take(proof).has_value());

  Handshake second = Handshake::answer(key_of(7));
  ASSERT_TRUE(second.take(hello).has_value());
  EXPECT_FALSE(second.take(proof).has_value()) << "the nonce is another";
  // Nor does the answerer's own proof, sent back to it.
  Handshake third = Handshake::answer(key_of(7));
  const std::string challenge = third.take(hello).value();
  EXPECT_FALSE(third.take(challenge.substr(32)).has_value());
}

class Connections : public ::testing::Test {
 protected:
  fs::path dir = fs::temp_directory_path() / ("granary_protocol_" + std::to_string(getpid()));
  RealLoop loop;
  Digest secret{};

  void SetUp() override {
    fs::create_directories(dir);
    secret = campaign_secret(dir).value();
  }
  void TearDown() override { fs::remove_all(dir); }

  /// Runs the loop until `done`, or for 5 s.
  void run_until(const std::function<bool()>& done) {
    std::function<void()> look = [&] {
      if (done()) return loop.stop();
      loop.after(0.002, look);
    };
    const TimerId limit = loop.after(5.0, [&] { loop.stop(); });
    look();
    loop.run();
    loop.cancel(limit);
    EXPECT_TRUE(done());
  }
};

TEST_F(Connections, CarryManyMessagesBothWaysInOrder) {
  std::vector<std::int64_t> there, back;
  const auto listener = Listener::listen(loop, "127.0.0.1", secret, [&](Channel& channel) -> Listener::Guest {
                          return {[&](const json::Value& message) {
                                    there.push_back(message.integer_or("n", -1));
                                    channel.send(message);
                                  },
                                  {}};
                        }).value();
  std::optional<Channel> caller;
  caller.emplace(loop, connect_tcp({"127.0.0.1"}, listener->port(), 1.0).value(),
                 Handshake::call(secret, Role::agent, "n"),
                 Channel::Events{[&] {
                                   for (int n = 0; n < 5000; ++n)
                                     caller->send(json::Value::object({{"n", n}, {"text", std::string(300, 'x')}}));
                                 },
                                 [&](const json::Value& message) { back.push_back(message.integer_or("n", -1)); },
                                 [](const std::string& why) { FAIL() << why; }});
  run_until([&] { return back.size() == 5000; });

  EXPECT_TRUE(std::is_sorted(there.begin(), there.end()));
  EXPECT_EQ(there, back);
  EXPECT_FALSE(caller->send(json::Value::object({{"n", std::string(kLargestPayload, 'x')}}))) << "too long";
}

TEST_F(Connections, ThatSendTooMuchWaitAndLoseNothingAndOthersAreServed) {
  constexpr std::int64_t kAll = 260'000, kMostInASecond = 200'000, kMostInAFrame = kLargestPayload / 9;  // {"n":0},
  std::int64_t taken = 0, taken_when_served = -1;
  const auto listener = Listener::listen(loop, "127.0.0.1", secret, [&](Channel& channel) -> Listener::Guest {
                          if (channel.name() == "flood")
                            return {[&](const json::Value& message) {
                                      EXPECT_EQ(message.integer_or("n", -1), taken);
                                      ++taken;
                                    },
                                    {}};
                          return {[&](const json::Value&) { taken_when_served = taken; }, {}};
                        }).value();
  std::optional<Channel> flood, quiet;
  flood.emplace(loop, connect_tcp({"127.0.0.1"}, listener->port(), 1.0).value(),
                Handshake::call(secret, Role::agent, "flood"),
                Channel::Events{[&] {
                                  for (std::int64_t n = 0; n < kAll; ++n) flood->send(json::Value::object({{"n", n}}));
                                },
                                [](const json::Value&) {}, [](const std::string& why) { FAIL() << why; }});
  run_until([&] { return taken > kMostInASecond / 2; });
  const double begin = loop.now();
  quiet.emplace(loop, connect_tcp({"127.0.0.1"}, listener->port(), 1.0).value(),
                Handshake::call(secret, Role::agent, "quiet"),
                Channel::Events{[&] {
                                  quiet->send(json::Value::object({{"n", 1}}));
                                },
                                [](const json::Value&) {}, [](const std::string& why) { FAIL() << why; }});
  run_until([&] { return taken_when_served >= 0; });
  EXPECT_LE(taken_when_served, kMostInASecond + kMostInAFrame);
  run_until([&] { return taken == kAll; });
  EXPECT_GE(loop.now() - begin, 0.5) << "held back for a second";
}

TEST_F(Connections, OfStrangersAreClosedAndNobodyIsTold) {
  int welcomed = 0;
  const auto listener = Listener::listen(loop, "127.0.0.1", secret, [&](Channel&) -> Listener::Guest {
                          ++welcomed;
                          return {};
                        }).value();
  std::string why;
  Digest other = secret;
  other[0] ^= 1;
  Channel thief(loop, connect_tcp({"127.0.0.1"}, listener->port(), 1.0).value(),
                Handshake::call(other, Role::agent, "n"),
                {[] {}, [](const json::Value&) {}, [&](const std::string& reason) { why = reason; }});
  const int noise = connect_tcp({"127.0.0.1"}, listener->port(), 1.0).value();
  ASSERT_EQ(send(noise, "GET / HTTP/1.1\r\n\r\n", 18, MSG_NOSIGNAL), 18);
  bool noise_closed = false;
  run_until([&] {
    char byte = 0;
    noise_closed = noise_closed || recv(noise, &byte, 1, MSG_DONTWAIT) == 0;
    return noise_closed && !why.empty();
  });
  close(noise);

  EXPECT_EQ(welcomed, 0);
  EXPECT_THAT(why, HasSubstr("does not know the secret"));
}

TEST_F(Connections, MayBeDestroyedInTheirOwnCallbacks) {
  int messages = 0;
  std::unique_ptr<Listener> listener;
  listener = Listener::listen(loop, "127.0.0.1", secret, [&](Channel& channel) -> Listener::Guest {
               return {[&](const json::Value&) {
                         ++messages;
                         listener->drop(channel);
                       },
                       {}};
             }).value();
  std::optional<Channel> caller;
  bool gone = false;
  caller.emplace(loop, connect_tcp({"127.0.0.1"}, listener->port(), 1.0).value(),
                 Handshake::call(secret, Role::agent, "n"),
                 Channel::Events{[&] {
                                   for (int n = 0; n < 3; ++n) caller->send(json::Value::object({{"n", n}}));
                                 },
                                 [](const json::Value&) {},
                                 [&](const std::string&) {
                                   caller.reset();
                                   gone = true;
                                 }});
  run_until([&] { return gone; });

  EXPECT_EQ(messages, 1) << "nothing comes after drop()";
}

TEST_F(Connections, AnswerThoseWhoAskFromAnotherHost) {
  EXPECT_THAT(ask_remote(dir, json::Value::object(), 1.0).error().message, HasSubstr("endpoint.json"));
  const int pid = fork();
  if (pid == 0) {
    RealLoop child;
    const auto listener = Listener::listen(child, "127.0.0.1", secret, [&](Channel& channel) -> Listener::Guest {
                            return {[&](const json::Value& request) {
                                      channel.send(json::Value::object({{"asked", request.text_or("ask", "")}}));
                                    },
                                    {}};
                          }).value();
    (void)write_endpoint(dir, {"elsewhere", {"127.0.0.1"}, listener->port(), 0});
    child.after(20.0, [&] { child.stop(); });
    child.run();
    _exit(0);
  }
  for (int k = 0; k < 1000 && !fs::exists(dir / "endpoint.json"); ++k) usleep(5000);

  const auto answer = ask_remote(dir, json::Value::object({{"ask", "status"}}), 5.0);
  kill(pid, SIGKILL);

  ASSERT_TRUE(answer.has_value()) << answer.error().message;
  EXPECT_EQ(answer->text_or("asked", ""), "status");
  EXPECT_FALSE(ask_remote(dir, json::Value::object(), 1.0).has_value()) << "nobody is there any more";
}

TEST_F(Connections, TakeASecretOnlyIfItIsOne) {
  struct stat status = {};
  ASSERT_EQ(stat((dir / "secret").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  EXPECT_EQ(campaign_secret(dir).value(), secret) << "it stays the same";
  fs::create_directories(dir / "other");
  EXPECT_NE(campaign_secret(dir / "other").value(), secret);

  chmod((dir / "secret").c_str(), 0640);
  EXPECT_THAT(read_secret(dir).error().message, HasSubstr("others may read it"));
  chmod((dir / "secret").c_str(), 0600);
  fs::resize_file(dir / "secret", 31);
  EXPECT_THAT(read_secret(dir).error().message, HasSubstr("less than 32 bytes"));
}

}  // namespace
}  // namespace granary::pilot
