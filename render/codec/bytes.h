// Numbers as little-endian bytes, a reader that cannot run past its end, and a hash of bytes.
// The hash multiplies and rotates as those of Steele, Lea, Flood 2014 do; it is ours and of no use against who wants two inputs to collide.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "render/core/transfer_vector.h"

namespace warpscope {

template <class T>
  requires std::is_unsigned_v<T>
void storeLittle(std::byte* place, T value) {
  for (size_t i = 0; i < sizeof(T); ++i) place[i] = static_cast<std::byte>(value >> 8 * i & 255);
}

template <class T>
  requires std::is_unsigned_v<T>
T loadLittle(const std::byte* place) {
  T value = 0;
  if constexpr (std::endian::native == std::endian::little)
    std::memcpy(&value, place, sizeof(T));  // one load, whatever the optimiser makes of the loop below
  else
    for (size_t i = 0; i < sizeof(T); ++i) value |= static_cast<T>(std::to_integer<T>(place[i]) << 8 * i);
  return value;
}

/// What payloads are made in.
using ByteVector = TransferVector<std::byte>;

/// So many bytes more, whatever they are, and where they begin.
template <class Allocator>
std::byte* grown(std::vector<std::byte, Allocator>& bytes, size_t count) {
  bytes.resize(bytes.size() + count);
  return bytes.data() + bytes.size() - count;
}

template <class Allocator, class T>
void appendLittle(std::vector<std::byte, Allocator>& bytes, T value) {
  storeLittle(grown(bytes, sizeof(T)), value);
}

/// Reads from front to back. Past the end it gives zeros and empty spans, and says so from then on.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class T>
  T take() {
    const std::span<const std::byte> bytes = take(sizeof(T));
    return bytes.empty() ? T{0} : loadLittle<T>(bytes.data());
  }
  std::span<const std::byte> take(size_t count) {
    if (count > rest_.size()) {
      ranOut_ = true;
      rest_ = {};
      return {};
    }
    const std::span<const std::byte> taken = rest_.first(count);
    rest_ = rest_.subspan(count);
    return taken;
  }

  bool ranOut() const { return ranOut_; }
  size_t left() const { return rest_.size(); }

 private:
  std::span<const std::byte> rest_;
  bool ranOut_ = false;
};

/// A hash of 64-bit words, in four lanes so that multiplications overlap. Every step is invertible: a change of one word always shows.
class WordHash {
 public:
  explicit WordHash(uint64_t seed) : lanes_{seed ^ kStart, seed + kFactor, seed - kStart, seed ^ kFactor} {}

  void add(uint64_t word, size_t index) {
    uint64_t& lane = lanes_[index & 3];
    lane = next(lane, word);
  }
  /// Words that have the indices 0, 1, 2 and so on.
  void addAll(std::span<const uint64_t> words) {
    addAll(words.size(), [words](size_t i) { return words[i]; });
  }
  template <class WordAt>
  void addAll(size_t count, WordAt wordAt) {
    uint64_t a = lanes_[0], b = lanes_[1], c = lanes_[2], d = lanes_[3];
    size_t i = 0;
    for (; i + 4 <= count; i += 4) {
      a = next(a, wordAt(i));
      b = next(b, wordAt(i + 1));
      c = next(c, wordAt(i + 2));
      d = next(d, wordAt(i + 3));
    }
    lanes_[0] = a;
    lanes_[1] = b;
    lanes_[2] = c;
    lanes_[3] = d;
    for (; i < count; ++i) add(wordAt(i), i);
  }
  uint64_t value() const {
    uint64_t all = kStart;
    for (const uint64_t lane : lanes_) {
      all = (all ^ lane) * kFactor;
      all ^= all >> 32;
    }
    return all;
  }

 private:
  static constexpr uint64_t kFactor = 0x9e3779b97f4a7c15u;  // odd: 2^64 over the golden ratio
  static constexpr uint64_t kStart = 0x243f6a8885a308d3u;   // pi's fraction

  static uint64_t next(uint64_t lane, uint64_t word) { return std::rotl((lane ^ word) * kFactor, 29); }

  uint64_t lanes_[4];
};

inline uint64_t hashBytes(std::span<const std::byte> bytes, uint64_t seed) {
  WordHash hash(seed ^ bytes.size() << 8);
  const size_t words = bytes.size() / 8;
  const std::byte* const begin = bytes.data();
  hash.addAll(words, [begin](size_t i) { return loadLittle<uint64_t>(begin + 8 * i); });
  uint64_t last = 0;
  for (size_t i = 8 * words; i < bytes.size(); ++i) last = last << 8 | std::to_integer<uint64_t>(bytes[i]);
  hash.add(last, words);
  return hash.value();
}

}  // namespace warpscope
