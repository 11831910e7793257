// Eight pixels at once: which of them have anything, as the bits of a byte, the first the lowest. On little-endian machines; elsewhere one by one.
// Bytes of a word side by side (SWAR): Warren 2013, "Hacker's Delight", chapter 6.
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/codec/bytes.h"

namespace warpscope {

/// `count` of them, at most 8, are there.
inline uint32_t coveredBits(const uint8_t* counts, uint32_t count) {
  uint32_t bits = 0;
  if (count < 8) {
    for (uint32_t i = 0; i < count; ++i) bits |= counts[i] > 0 ? 1u << i : 0u;
    return bits;
  }
  constexpr uint64_t kLows = 0x7f7f7f7f7f7f7f7fu, kGather = 0x0102040810204080u;
  const uint64_t word = loadLittle<uint64_t>(reinterpret_cast<const std::byte*>(counts));
  const uint64_t tops = (((word & kLows) + kLows) | word) & ~kLows;  // a byte's highest bit where it is not 0
  return static_cast<uint32_t>((tops >> 7) * kGather >> 56);
}

/// Back: 1 or 0 for each.
inline void spreadBits(uint32_t bits, uint8_t* counts, uint32_t count) {
  if (count < 8) {
    for (uint32_t i = 0; i < count; ++i) counts[i] = bits >> i & 1;
    return;
  }
  constexpr uint64_t kEach = 0x8040201008040201u, kOnes = 0x0101010101010101u, kLows = 0x7f7f7f7f7f7f7f7fu;
  const uint64_t own = bits * kOnes & kEach;
  storeLittle(reinterpret_cast<std::byte*>(counts), (((own & kLows) + kLows) | own) >> 7 & kOnes);
}

}  // namespace warpscope
