// The hash that a payload's head has of all behind it. The format is part of what is hashed.
// Of tiled payloads it is a sum over words (summed_hash.h), which are made and read in less time than one core takes for any other: who has added up some of them already says so.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace warpscope {

/// Format and hash.
inline constexpr size_t kPayloadHeadBytes = 9;
inline constexpr size_t kHashedWordBytes = 8;

/// What words of a payload add up to (placedHash). They are counted from the head's end.
struct SummedWords {
  size_t begin = 0, end = 0;
  uint64_t sum = 0;

  /// Those that are whole within bytes of the payload, not added up yet. `at`: of the payload; none where that is in its head.
  static SummedWords within(size_t at, size_t bytes) {
    if (at < kPayloadHeadBytes) return {};
    const size_t first = at - kPayloadHeadBytes, begin = (first + kHashedWordBytes - 1) / kHashedWordBytes;
    const size_t end = (first + bytes) / kHashedWordBytes;
    return end > begin ? SummedWords{begin, end, 0} : SummedWords{};
  }
  constexpr size_t count() const { return end - begin; }
  size_t firstByte() const { return kPayloadHeadBytes + kHashedWordBytes * begin; }  ///< of the payload
};

/// Of a payload with a head, whatever that says. `summed`: of tiled payloads alone; one behind the other.
uint64_t payloadHash(std::span<const std::byte> payload, std::span<const SummedWords> summed = {});

/// Writes that into the head, for who made or changed what is behind it; nothing where there is none.
void sealPayload(std::span<std::byte> payload, std::span<const SummedWords> summed = {});

}  // namespace warpscope
