// Hexadecimal digits.
// See fingerprint.h.
#include "net/fingerprint.h"

#include <charconv>

namespace warpscope::net {

std::string fingerprintText(const Fingerprint& fingerprint) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const uint8_t byte : fingerprint) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

std::optional<Fingerprint> parseFingerprint(std::string_view text) {
  Fingerprint fingerprint;
  if (text.size() != 2 * fingerprint.size()) return std::nullopt;
  for (size_t i = 0; i < fingerprint.size(); ++i) {
    const char* const first = text.data() + 2 * i;
    const auto [end, error] = std::from_chars(first, first + 2, fingerprint[i], 16);
    if (error != std::errc{} || end != first + 2) return std::nullopt;
  }
  return fingerprint;
}

}  // namespace warpscope::net
