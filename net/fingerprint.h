// The fingerprint of a certificate: SHA-256 of its DER form, by which a client knows its server.
// Written as 64 hexadecimal digits.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace warpscope::net {

using Fingerprint = std::array<uint8_t, 32>;

/// Lower-case digits.
std::string fingerprintText(const Fingerprint& fingerprint);

/// Digits of either case; nothing if they are not 64 of them.
std::optional<Fingerprint> parseFingerprint(std::string_view text);

}  // namespace warpscope::net
