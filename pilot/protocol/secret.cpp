#include "pilot/protocol/secret.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace granary::pilot {

namespace fs = std::filesystem;

namespace {

Error secret_error(const fs::path& file, const std::string& what) { return {file.string() + ": " + what}; }

/// Makes the file with its content in one step that only one can win: written beside, then linked.
Status make_secret(const fs::path& file) {
  const fs::path beside = fmt::format("{}.{}", file.string(), getpid());
  const int fd = open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  const Digest secret = random_digest();
  const bool written =
      fd >= 0 && write(fd, secret.data(), secret.size()) == static_cast<ssize_t>(secret.size()) && fsync(fd) == 0;
  int code = written ? 0 : errno;
  if (fd >= 0) close(fd);
  if (code == 0 && link(beside.c_str(), file.c_str()) != 0 && errno != EEXIST) code = errno;
  unlink(beside.c_str());
  if (code != 0) return secret_error(file, fmt::format("cannot be made: {}", std::strerror(code)));
  return {};
}

}  // namespace

Digest hmac(const Digest& key, std::initializer_list<std::string_view> parts) {
  std::string text;
  for (const std::string_view part : parts) text += part;
  Digest digest{};
  unsigned int size = digest.size();
  const unsigned char* done =
      HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()), reinterpret_cast<const unsigned char*>(text.data()),
           text.size(), digest.data(), &size);
  GRANARY_ASSERT(done != nullptr && size == digest.size());
  return digest;
}

bool same_digest(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

Digest random_digest() {
  Digest digest{};
  for (std::size_t have = 0; have < digest.size();) {
    const ssize_t n = getrandom(digest.data() + have, digest.size() - have, 0);
    if (n > 0) have += static_cast<std::size_t>(n);
  }
  return digest;
}

Result<Digest> read_secret(const fs::path& dir) {
  const fs::path file = dir / "secret";
  const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (fd < 0) return secret_error(file, fmt::format("cannot be read: {}", std::strerror(errno)));
  struct stat status = {};
  Digest secret{};
  const bool known = fstat(fd, &status) == 0;
  const bool whole = known && read(fd, secret.data(), secret.size()) == static_cast<ssize_t>(secret.size());
  close(fd);
  if (known && (status.st_uid != geteuid() || (status.st_mode & 077) != 0))
    return secret_error(file,
                        "belongs to another user, or others may read it: it is no secret. Delete it, then resume.");
  if (!whole) return secret_error(file, "holds less than 32 bytes. Delete it, then resume.");
  return secret;
}

Result<Digest> campaign_secret(const fs::path& dir) {
  std::error_code ignored;
  if (!fs::exists(dir / "secret", ignored)) GRANARY_CHECK(make_secret(dir / "secret"));
  return read_secret(dir);
}

std::string campaign_tag(const Digest& secret) {
  std::string text;
  const Digest digest = hmac(secret, {"granary campaign tag"});
  for (std::size_t k = 0; k < 8; ++k) text += fmt::format("{:02x}", digest[k]);
  return text;
}

}  // namespace granary::pilot
