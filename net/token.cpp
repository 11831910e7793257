// Drawing, writing, reading and comparing tokens.
// See token.h.
#include "net/token.h"

#include <openssl/crypto.h>
#include <sys/random.h>

#include <cerrno>
#include <system_error>

namespace warpscope::net {
namespace {

constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";

}  // namespace

Token Token::random() {
  std::array<uint8_t, kBytes> bytes;
  ssize_t count;
  do {
    count = getrandom(bytes.data(), bytes.size(), 0);
  } while (count < 0 && errno == EINTR);
  // So few bytes come whole or not at all (getrandom(2)).
  if (count != static_cast<ssize_t>(bytes.size())) throw std::system_error(errno, std::generic_category(), "no random numbers for a token");
  return Token(bytes);
}

std::optional<Token> Token::parse(std::string_view text) {
  if (text.size() != kCharacters) return std::nullopt;
  std::array<uint8_t, kBytes> bytes;
  for (size_t group = 0; group < kBytes / 3; ++group) {
    uint32_t bits = 0;
    for (const char character : text.substr(4 * group, 4)) {
      const size_t digit = kDigits.find(character);
      if (digit == std::string_view::npos) return std::nullopt;
      bits = bits << 6 | static_cast<uint32_t>(digit);
    }
    for (size_t i = 0; i < 3; ++i) bytes[3 * group + i] = static_cast<uint8_t>(bits >> (16 - 8 * i));
  }
  return Token(bytes);
}

std::string Token::text() const {
  std::string text;
  for (size_t group = 0; group < kBytes / 3; ++group) {
    uint32_t bits = 0;
    for (size_t i = 0; i < 3; ++i) bits = bits << 8 | bytes_[3 * group + i];
    for (int shift = 18; shift >= 0; shift -= 6) text += kDigits[bits >> shift & 63];
  }
  return text;
}

bool operator==(const Token& a, const Token& b) {
  return CRYPTO_memcmp(a.bytes_.data(), b.bytes_.data(), Token::kBytes) == 0;
}

}  // namespace warpscope::net
