// Any journal to go on from: any bytes; a true one with damage; and lines of right checksum that tell of anything. Each
// is refused with a message, or read; what is read is the journal's beginning, and what is kept of it reads the same.
#include <fuzzer/FuzzedDataProvider.h>

#include <filesystem>
#include <string>
#include <vector>

#include "pilot/journal/journal.hpp"
#include "pilot/task/event.hpp"
#include "tests/fuzz/fuzz_support.hpp"

namespace {

using namespace granary;
using fuzz::demand;
using namespace granary::pilot;
namespace fs = std::filesystem;

const fuzz::OwnFile& place() {
  static const fuzz::OwnFile one("journal.jsonl");
  return one;
}

/// What can be read of it, after all that must hold for any bytes.
std::vector<Record> read_back(const std::string& bytes) {
  place().put(bytes);
  const auto content = read_journal(place().path());
  if (!content) {
    demand(content.error().message.find("journal.jsonl") != std::string::npos, "a refusal names the file");
    return {};
  }
  demand(content->whole_bytes + content->dropped_bytes == bytes.size(), "every byte is kept or dropped");
  for (std::size_t k = 0; k < content->records.size(); ++k)
    demand(content->records[k].sequence == k + 1, "no line is missing");
  {
    const auto opened = Journal::open(place().path());
    demand(opened.has_value(), "what can be read can be gone on with");
    demand(opened->n_records() == content->records.size(), "all of it");
  }
  const auto again = read_journal(place().path());
  demand(again && again->dropped_bytes == 0 && again->records.size() == content->records.size(),
         "what is kept is whole and reads the same");
  for (const Record& record : content->records) {
    const auto event = event_from_json(record.kind, record.payload);
    if (event) demand(kind_of(*event) == record.kind, "an event is of the kind it was read from");
  }
  return content->records;
}

const std::vector<std::string>& kinds() {
  static const std::vector<std::string> list{"pilot.open",      "task.submit",       "task.place",   "task.start",
                                             "task.exit",       "task.stop",         "task.lost",    "task.suspend",
                                             "task.resume",     "task.timeout",      "task.reopen",  "task.preempt",
                                             "task.grace_over", "task.start_failed", "task.abandon", "coupling.event"};
  return list;
}

/// Lines of right checksum and numbering, of any payload.
std::string any_lines(FuzzedDataProvider& choices) {
  std::string text;
  std::uint64_t n = 0;
  while (choices.remaining_bytes() > 0 && text.size() < 8192) {
    std::string payload = choices.ConsumeRandomLengthString(120);
    const std::string number = std::to_string(choices.ConsumeIntegral<std::int16_t>());
    if (choices.ConsumeBool())
      payload = "{\"time_s\":" + number + ",\"id\":" + std::to_string(choices.ConsumeIntegralInRange(-1, 3)) +
                ",\"attempt\":" + std::to_string(choices.ConsumeIntegralInRange(-1, 3)) + ",\"cores\":\"" +
                choices.ConsumeRandomLengthString(12) + "\",\"task\":{\"name\":\"a\",\"command\":[\"b\"]}}";
    const std::string kind = choices.ConsumeBool() ? choices.ConsumeRandomLengthString(20)
                                                   : kinds()[choices.ConsumeIntegralInRange<std::size_t>(0, 15)];
    append_line(text, {++n, 1.0, kind, payload});
  }
  return text;
}

/// A true journal with bytes changed, or its end cut off.
void try_damaged(FuzzedDataProvider& choices) {
  std::string whole;
  std::vector<std::string> payloads;
  for (std::uint64_t n = 1; n <= 6; ++n) {
    payloads.push_back("{\"time_s\":0.5,\"id\":0,\"attempt\":" + std::to_string(n) + "}");
    append_line(whole, {n, 1e9, "task.start", payloads.back()});
  }
  std::string bytes = whole;
  if (choices.ConsumeBool()) bytes.resize(choices.ConsumeIntegralInRange<std::size_t>(0, bytes.size()));
  while (!bytes.empty() && choices.remaining_bytes() > 0)
    bytes[choices.ConsumeIntegralInRange<std::size_t>(0, bytes.size() - 1)] = choices.ConsumeIntegral<char>();
  const auto records = read_back(bytes);
  demand(records.size() <= 6, "no record is made up");
  for (std::size_t k = 0; k < records.size(); ++k)
    demand(records[k].kind == "task.start" && records[k].payload.integer_or("attempt", 0) == static_cast<int>(k) + 1,
           "damage is seen");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  FuzzedDataProvider choices(data + 1, size - 1);
  if (data[0] == 'd') {
    try_damaged(choices);
  } else if (data[0] == 'l') {
    read_back(any_lines(choices));
  } else {
    read_back(choices.ConsumeRemainingBytesAsString());
  }
  return 0;
}
