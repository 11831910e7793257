// Tokens: the secret that a server gives out with its address, and that a client has to show.
// 192 bits from the operating system, written in base64url (RFC 4648, section 5; no padding is needed).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace warpscope::net {

class Token {
 public:
  static constexpr size_t kBytes = 24;
  static constexpr size_t kCharacters = kBytes / 3 * 4;

  explicit Token(const std::array<uint8_t, kBytes>& bytes) : bytes_(bytes) {}

  /// Throws std::system_error if the operating system has no random numbers.
  static Token random();
  /// Nothing if `text` is no token: 32 characters of A-Z a-z 0-9 - _.
  static std::optional<Token> parse(std::string_view text);

  /// The secret in the open: for addresses that are handed over, and never for logs.
  std::string text() const;
  std::span<const uint8_t, kBytes> bytes() const { return bytes_; }

  /// Takes the same time wherever the two differ.
  friend bool operator==(const Token& a, const Token& b);

 private:
  std::array<uint8_t, kBytes> bytes_;
};

}  // namespace warpscope::net
