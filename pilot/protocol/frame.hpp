// Messages on a stream of bytes. Pure: no sockets, no clock. Layout and reasons: docs/slurm.md#protocol.
//
//   plain frame    length (4 bytes, big-endian)  payload                                   handshake only
//   sealed frame   length                        sequence (8)  HMAC-SHA256 (32)  payload   HMAC over sequence, payload
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "pilot/protocol/secret.hpp"

namespace granary::pilot {

inline constexpr std::size_t kLargestPayload = 1 << 20;  ///< of a sealed frame [bytes]
inline constexpr std::size_t kLargestGreeting = 512;     ///< of a plain frame [bytes]

std::string plain_frame(std::string_view payload);

/// Seals the frames of one direction of a connection, counting them.
class FrameWriter {
 public:
  explicit FrameWriter(const Digest& key) : key_(key) {}
  /// `payload`: at most kLargestPayload bytes (asserted).
  std::string seal(std::string_view payload);

 private:
  Digest key_;
  std::uint64_t sequence_ = 0;
};

/// Takes bytes as they come and gives whole payloads. Begins with plain frames; sealed ones are expected from expect().
class FrameReader {
 public:
  void feed(std::string_view bytes) { buffer_.append(bytes); }
  /// From here on frames are sealed with this key, and counted from 1.
  void expect(const Digest& key) { key_ = key; }

  /// The next payload; nothing if more bytes are needed, or never again (broken()). A frame with a wrong seal, or one
  /// that was there already, is dropped and counted; it does not end the connection until there are kMostDropped.
  std::optional<std::string> next();

  /// Why nothing more can be read here: a frame too long or too short, one that is missing, too many that are wrong.
  const std::string& broken() const { return broken_; }
  int dropped() const { return dropped_; }
  /// What was wrong with the frame dropped last.
  const std::string& last_dropped() const { return last_dropped_; }

  static constexpr int kMostDropped = 16;

 private:
  std::optional<std::string> unseal(std::string_view frame);
  void drop(std::string why);

  std::string buffer_;
  std::size_t at_ = 0;  ///< in buffer_: where the next frame begins
  std::optional<Digest> key_;
  std::uint64_t sequence_ = 0;
  int dropped_ = 0;
  std::string last_dropped_, broken_;
};

}  // namespace granary::pilot
