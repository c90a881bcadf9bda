// Who is let in by the web page.
#include <gtest/gtest.h>

#include "controller/serve/gate.hpp"

namespace granary::serve {
namespace {

const Gate kGate{"0123456789abcdef0123456789abcdef", "127.0.0.1"};
const std::string kGood = "/" + kGate.token + "/";

unsigned status(const std::string& target, const std::string& host = "127.0.0.1:8080",
                const std::string& method = "GET") {
  const auto admitted = kGate.admit(method, target, host);
  const auto* refusal = std::get_if<Refusal>(&admitted);
  return refusal != nullptr ? refusal->status : 200;
}

TEST(Gate, LetsInWhoeverKnowsTheWholeToken) {
  EXPECT_EQ(Place::page, std::get<Place>(kGate.admit("GET", kGood, "127.0.0.1:8080")));
  EXPECT_EQ(Place::events, std::get<Place>(kGate.admit("GET", kGood + "events", "localhost:1")));
  EXPECT_EQ(Place::view, std::get<Place>(kGate.admit("GET", kGood + "view.json?x=1", "[::1]:80")));
}

TEST(Gate, RefusesEveryOtherToken) {
  EXPECT_EQ(403U, status("/"));
  EXPECT_EQ(403U, status(""));
  EXPECT_EQ(403U, status("/events"));
  EXPECT_EQ(403U, status("/" + kGate.token));
  EXPECT_EQ(403U, status("/" + kGate.token + "x/"));
  for (std::size_t k = 1; k <= kGate.token.size(); ++k) {
    std::string wrong = kGood;
    wrong[k] = wrong[k] == '0' ? '1' : '0';
    EXPECT_EQ(403U, status(wrong)) << k;
    EXPECT_EQ(403U, status("/" + kGate.token.substr(0, k - 1) + "/")) << k;
  }
}

TEST(Gate, RefusesOtherHostsSoThatNoSiteCanRebindItsNameToUs) {
  for (const char* host : {"evil.example", "evil.example:8080", "127.0.0.1.evil.example", "localhost.evil.example:8080",
                           "", "10.0.0.7", "[::2]:80", "127.0.0.1@evil.example"})
    EXPECT_EQ(421U, status(kGood, host)) << host;
}

TEST(Gate, KnowsNothingButItsPagesAndGet) {
  EXPECT_EQ(404U, status(kGood + "../journal.jsonl"));
  EXPECT_EQ(404U, status(kGood + "campaign.json"));
  EXPECT_EQ(405U, status(kGood, "localhost", "POST"));
}

TEST(Gate, TokensAreLongAndDiffer) {
  EXPECT_EQ(32U, new_token().size());
  EXPECT_NE(new_token(), new_token());
}

}  // namespace
}  // namespace granary::serve
