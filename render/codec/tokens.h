// Integers that are mostly small as one byte each, which an entropy coder shortens, and the bits that such a coder would not shorten anyway.
// Cf. the hybrid integers of JPEG XL (ISO/IEC 18181-1, annex C): below 16 the token is the number; above, its magnitude and highest bit.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "render/core/host_device.h"

namespace warpscope {

WARPSCOPE_HD inline uint32_t zigzag(int32_t value) { return static_cast<uint32_t>(value) << 1 ^ static_cast<uint32_t>(value >> 31); }
WARPSCOPE_HD inline int32_t unzigzag(uint32_t code) { return static_cast<int32_t>(code >> 1 ^ (0u - (code & 1))); }

/// Bits, the first in the lowest place of a byte. Writes into memory that has room for all of them and kSpareBytes more.
class BitWriter {
 public:
  static constexpr size_t kSpareBytes = 8;

  explicit BitWriter(uint8_t* to) : begin_(to), next_(to) {}

  /// The lower `count` bits of `value`, which has no others; count <= 32.
  void put(uint32_t value, uint32_t count) {
    pending_ |= static_cast<uint64_t>(value) << count_;
    count_ += count;
    store();
    next_ += count_ / 8;
    pending_ >>= count_ & ~7u;
    count_ &= 7;
  }
  /// All bytes, once; the last is filled up with zeros.
  std::span<const uint8_t> finish() {
    store();
    next_ += (count_ + 7) / 8;
    return {begin_, next_};
  }

 private:
  void store() {
    for (uint32_t i = 0; i < 8; ++i) next_[i] = static_cast<uint8_t>(pending_ >> 8 * i);
  }

  uint8_t* begin_;
  uint8_t* next_;
  uint64_t pending_ = 0;
  uint32_t count_ = 0;  // < 8 between calls
};

/// Past the end there are zeros, and ranOut() says so.
class BitReader {
 public:
  explicit BitReader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  /// count <= 32.
  uint32_t take(uint32_t count) {
    if (count_ < count) fill();
    const auto value = static_cast<uint32_t>(pending_ & ((uint64_t{1} << count) - 1));
    pending_ >>= count;
    count_ -= count;
    return value;
  }
  bool ranOut() const { return 8 * next_ - count_ > 8 * bytes_.size(); }

 private:
  /// As many whole bytes as there is room for: at least 32 bits are there then. Those loaded beyond count_ are the ones that come next, and
  /// are put there again (Giesen 2018, "Reading bits in far too many ways", variant 4).
  void fill() {
    if (next_ + 8 <= bytes_.size()) {
      uint64_t word = 0;
      for (uint32_t i = 0; i < 8; ++i) word |= static_cast<uint64_t>(bytes_[next_ + i]) << 8 * i;
      pending_ |= word << count_;
      const uint32_t fitting = (63 - count_) / 8;
      next_ += fitting;
      count_ += 8 * fitting;
      return;
    }
    for (; count_ <= 56; count_ += 8, ++next_)
      pending_ |= static_cast<uint64_t>(next_ < bytes_.size() ? bytes_[next_] : 0) << count_;
  }

  std::span<const uint8_t> bytes_;
  size_t next_ = 0;
  uint64_t pending_ = 0;
  uint32_t count_ = 0;
};

inline constexpr uint32_t kDirectTokens = 16;
inline constexpr uint32_t kLargestToken = kDirectTokens + 2 * 27 + 1;
inline constexpr uint32_t kMostTokenBits = 30;  ///< beside the token

/// Bits of a number that its token does not say, which lie below its two highest ones.
WARPSCOPE_HD inline uint32_t restBits(uint32_t token) { return token < kDirectTokens ? 0 : ((token < kLargestToken ? token : kLargestToken) - kDirectTokens) / 2 + 3; }
WARPSCOPE_HD inline uint32_t tokenOf(uint32_t value) {
  if (value < kDirectTokens) return value;
#if defined(__CUDA_ARCH__)
  const auto length = static_cast<uint32_t>(32 - __clz(static_cast<int>(value)));  // 5..32
#else
  const auto length = static_cast<uint32_t>(std::bit_width(value));  // 5..32
#endif
  return kDirectTokens + 2 * (length - 5) + (value >> (length - 2) & 1);
}
/// Of a token that is too large, something. `rest` has restBits(token) bits.
WARPSCOPE_HD inline uint32_t valueOf(uint32_t token, uint32_t rest) {
  if (token < kDirectTokens) return token;
  return (2u + (token & 1)) << restBits(token) | rest;
}

inline uint8_t putToken(uint32_t value, BitWriter& bits) {
  const uint32_t token = tokenOf(value), below = restBits(token);
  if (below > 0) bits.put(value & ((1u << below) - 1), below);
  return static_cast<uint8_t>(token);
}

inline void putTokens(std::span<const uint32_t> values, std::span<uint8_t> tokens, BitWriter& bits) {
  const uint32_t* const value = values.data();
  uint8_t* const token = tokens.data();
  BitWriter put = bits;
  for (size_t i = 0; i < values.size(); ++i) token[i] = putToken(value[i], put);
  bits = put;
}

/// Of a token that is too large, something.
inline uint32_t takeToken(uint8_t token, BitReader& bits) {
  if (token < kDirectTokens) return token;
  return valueOf(token, bits.take(restBits(token)));
}

}  // namespace warpscope
