// Anybody may connect to a pilot's port and send any bytes; an agent may send any message. Frames: only what was sealed
// comes out, in order, once. Greetings: nobody is let in without the secret. Messages: refused, or read back as they
// are.
#include <fuzzer/FuzzedDataProvider.h>

#include <string>
#include <vector>

#include "common/json/io.hpp"
#include "pilot/agent/messages.hpp"
#include "pilot/protocol/frame.hpp"
#include "pilot/protocol/handshake.hpp"
#include "tests/fuzz/fuzz_support.hpp"

namespace {

using namespace granary;
using fuzz::demand;
using namespace granary::pilot;

Digest key_of(unsigned char byte) {
  Digest key{};
  key.fill(byte);
  return key;
}

/// Feeds the bytes in pieces and takes what comes out.
std::vector<std::string> taken(FrameReader& reader, std::string_view bytes, FuzzedDataProvider& choices) {
  std::vector<std::string> payloads;
  while (!bytes.empty()) {
    const std::size_t piece = choices.ConsumeIntegralInRange<std::size_t>(1, bytes.size());
    reader.feed(bytes.substr(0, piece));
    bytes.remove_prefix(piece);
    while (auto payload = reader.next()) payloads.push_back(std::move(*payload));
  }
  return payloads;
}

void try_any_bytes(FuzzedDataProvider& choices) {
  const bool sealed = choices.ConsumeBool();
  FrameReader reader;
  if (sealed) reader.expect(key_of(1));
  const std::string bytes = choices.ConsumeRandomLengthString();
  const auto payloads = taken(reader, bytes, choices);
  demand(!sealed || payloads.empty(), "nothing unsealed is taken");
  for (const std::string& payload : payloads)
    demand(!payload.empty() && payload.size() <= kLargestGreeting, "a plain frame has its size");
  demand(reader.dropped() <= FrameReader::kMostDropped, "a bound on what is dropped");
}

/// True frames that are changed, repeated, swapped, left out, and mixed with a stranger's.
void try_meddled(FuzzedDataProvider& choices) {
  FrameWriter writer(key_of(1)), stranger(key_of(2));
  std::vector<std::string> sent, frames;
  for (int k = choices.ConsumeIntegralInRange(1, 8); k > 0; --k) {
    sent.push_back(choices.ConsumeRandomLengthString(64));
    frames.push_back(writer.seal(sent.back()));
  }
  std::string bytes;
  while (choices.remaining_bytes() > 0 && bytes.size() < 8192) {
    std::string frame = frames[choices.ConsumeIntegralInRange<std::size_t>(0, frames.size() - 1)];
    if (choices.ConsumeIntegralInRange(0, 3) == 0) frame = stranger.seal(choices.ConsumeRandomLengthString(64));
    if (choices.ConsumeIntegralInRange(0, 3) == 0)
      frame[choices.ConsumeIntegralInRange<std::size_t>(0, frame.size() - 1)] ^= choices.ConsumeIntegral<char>();
    bytes += frame;
  }
  FrameReader reader;
  reader.expect(key_of(1));
  const auto payloads = taken(reader, bytes, choices);
  demand(payloads.size() <= sent.size(), "no frame is taken twice");
  for (std::size_t k = 0; k < payloads.size(); ++k) demand(payloads[k] == sent[k], "frames are taken in their order");
}

void try_greetings(FuzzedDataProvider& choices) {
  Handshake caller = Handshake::call(key_of(1), Role::agent, "node1"), answerer = Handshake::answer(key_of(1));
  const auto any = [&] { return choices.ConsumeRandomLengthString(200); };
  // Each message is the true one, or any other.
  bool all_true = choices.ConsumeBool();
  const auto challenge = answerer.take(all_true ? caller.first_message() : any());
  if (!challenge) return;
  const bool true_challenge = choices.ConsumeBool();
  const auto proof = caller.take(true_challenge ? *challenge : any());
  demand(!caller.done() || (all_true && true_challenge), "no answerer is believed without the secret");
  const bool true_proof = choices.ConsumeBool() && proof;
  (void)answerer.take(true_proof ? *proof : any());
  demand(!answerer.done() || (all_true && true_challenge && true_proof), "no caller is let in without the secret");
}

void try_message(FuzzedDataProvider& choices) {
  const auto value = json::parse(choices.ConsumeRemainingBytesAsString(), "message");
  if (!value) return;
  if (const auto launch = launch_from_json(*value)) {
    const std::string written = json::dump(to_json(*launch));
    const auto again = launch_from_json(*json::parse(written, "again"));
    demand(again && json::dump(to_json(*again)) == written, "a launch reads back as it was");
    launch->cores.for_each([](int core) { demand(core >= 0, "cores are numbers"); });
  }
  if (const auto report = report_from_json(*value)) demand(!report->cpus.empty(), "an agent has cores");
  (void)attempt_from_json((*value)["id"]);
  (void)end_from_json(*value);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  FuzzedDataProvider choices(data + 1, size - 1);
  switch (data[0]) {
    case 'f':
      try_meddled(choices);
      break;
    case 'g':
      try_greetings(choices);
      break;
    case 'm':
      try_message(choices);
      break;
    default:
      try_any_bytes(choices);
  }
  return 0;
}
