#include "pilot/protocol/frame.hpp"

#include <fmt/format.h>

#include "common/assert.hpp"

namespace granary::pilot {
namespace {

constexpr std::size_t kLengthBytes = 4, kSequenceBytes = 8;
constexpr std::size_t kSealBytes = kSequenceBytes + sizeof(Digest);

std::string big_endian(std::uint64_t value, std::size_t bytes) {
  std::string text(bytes, '\0');
  for (std::size_t k = bytes; k-- > 0; value >>= 8) text[k] = static_cast<char>(value & 0xff);
  return text;
}

std::uint64_t number_in(std::string_view bytes) {
  std::uint64_t value = 0;
  for (const char c : bytes) value = value << 8 | static_cast<unsigned char>(c);
  return value;
}

}  // namespace

std::string plain_frame(std::string_view payload) { return big_endian(payload.size(), kLengthBytes).append(payload); }

std::string FrameWriter::seal(std::string_view payload) {
  GRANARY_ASSERT(payload.size() <= kLargestPayload, payload.size());
  const std::string sequence = big_endian(++sequence_, kSequenceBytes);
  std::string frame = big_endian(kSealBytes + payload.size(), kLengthBytes);
  return frame.append(sequence).append(bytes_of(hmac(key_, {sequence, payload}))).append(payload);
}

std::optional<std::string> FrameReader::next() {
  while (broken_.empty() && buffer_.size() - at_ >= kLengthBytes) {
    const std::string_view rest = std::string_view(buffer_).substr(at_);
    const std::uint64_t length = number_in(rest.substr(0, kLengthBytes));
    const std::size_t least = key_ ? kSealBytes : 1, most = key_ ? kSealBytes + kLargestPayload : kLargestGreeting;
    if (length < least || length > most) {
      broken_ = fmt::format("a frame of {} bytes; {} to {} are allowed", length, least, most);
      buffer_.clear();
      at_ = 0;
      return std::nullopt;
    }
    if (rest.size() < kLengthBytes + length) break;
    const std::string_view frame = rest.substr(kLengthBytes, length);
    auto payload = key_ ? unseal(frame) : std::optional<std::string>(frame);
    at_ += kLengthBytes + length;
    if (payload) return payload;
  }
  buffer_.erase(0, at_);
  at_ = 0;
  return std::nullopt;
}

std::optional<std::string> FrameReader::unseal(std::string_view frame) {
  const std::string_view sequence = frame.substr(0, kSequenceBytes), payload = frame.substr(kSealBytes);
  if (!same_digest(frame.substr(kSequenceBytes, sizeof(Digest)), bytes_of(hmac(*key_, {sequence, payload})))) {
    drop("a message whose seal is wrong");
    return std::nullopt;
  }
  const std::uint64_t number = number_in(sequence);
  if (number <= sequence_) {
    drop(fmt::format("message {}, which was here before", number));
    return std::nullopt;
  }
  if (number != sequence_ + 1) {
    broken_ = fmt::format("message {} came where {} was to come", number, sequence_ + 1);
    return std::nullopt;
  }
  sequence_ = number;
  return std::string(payload);
}

void FrameReader::drop(std::string why) {
  last_dropped_ = std::move(why);
  if (++dropped_ >= kMostDropped) broken_ = fmt::format("{} messages were wrong or replayed", dropped_);
}

}  // namespace granary::pilot
