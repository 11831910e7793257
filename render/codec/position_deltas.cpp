// Differences of three coordinates as one of 125 codes. Loops read and write through locals only: what they write
// cannot be what they read then.
// See position_deltas.h.
#include "render/codec/position_deltas.h"

#include <array>
#include <cstdlib>

namespace warpscope {
namespace {

// Each coordinate differs by -2..2, or too much to say so.
constexpr int kReach = 2;
constexpr int kDeltas = 2 * kReach + 1;
constexpr int kNoDelta = (kReach * kDeltas + kReach) * kDeltas + kReach;
constexpr int kDeltaCodes = kDeltas * kDeltas * kDeltas;
constexpr uint8_t kExact = 0;
constexpr uint8_t kEscape = kDeltaCodes;
constexpr uint32_t kEscapedBits = kMostDeltaBits / 2;  // twice
static_assert(kMostDeltaBits == 3 * kPositionBits);

inline int coordinate(PackedSample sample, int axis) {
  return static_cast<int>(sample >> static_cast<int>(kPositionBits) * axis & kPositionMax);
}

inline uint8_t deltaCode(PackedSample sample, PackedSample place) {
  const int x = coordinate(sample, 0) - coordinate(place, 0), y = coordinate(sample, 1) - coordinate(place, 1),
            z = coordinate(sample, 2) - coordinate(place, 2);
  const bool isFar = glm::max(glm::max(std::abs(x), std::abs(y)), std::abs(z)) > kReach;
  const int code = ((x + kReach) * kDeltas + y + kReach) * kDeltas + z + kReach - kNoDelta;
  return static_cast<uint8_t>(isFar ? kEscape : code < 0 ? code + kDeltaCodes : code);
}

/// What deltaCode() stands for, for every byte: three coordinates to be added, each within its 18 bits.
constexpr std::array<PackedSample, 256> kMoves = [] {
  std::array<PackedSample, 256> moves{};
  for (int code = 0; code < 256; ++code) {
    const int shifted = (code + kNoDelta) % kDeltaCodes;
    const int deltas[] = {shifted / (kDeltas * kDeltas) - kReach, shifted / kDeltas % kDeltas - kReach,
                          shifted % kDeltas - kReach};
    for (int axis = 0; axis < 3; ++axis)
      moves[static_cast<size_t>(code)] |= static_cast<uint64_t>(static_cast<uint32_t>(deltas[axis]) & kPositionMax)
                                          << static_cast<int>(kPositionBits) * axis;
  }
  return moves;
}();
static_assert(kMoves[kExact] == 0 && kMoves[kEscape] == 0);

/// Coordinates that leave their 18 bits wrap around: no carry leaves a coordinate's highest bit.
inline PackedSample moved(PackedSample place, uint8_t deltaCode) {
  constexpr uint64_t kHighest = uint64_t{1} << (kPositionBits - 1) | uint64_t{1} << (2 * kPositionBits - 1) |
                                uint64_t{1} << (3 * kPositionBits - 1);
  const PackedSample move = kMoves[deltaCode];
  return ((place & ~kHighest) + (move & ~kHighest)) ^ ((place ^ move) & kHighest);
}

}  // namespace

void putDeltas(std::span<const PackedSample> samples, std::span<const PackedSample> places, std::span<uint8_t> deltas,
               BitWriter& bits) {
  const PackedSample* const sample = samples.data();
  const PackedSample* const place = places.data();
  uint8_t* const delta = deltas.data();
  const size_t count = deltas.size();
  for (size_t i = 0; i < count; ++i) delta[i] = deltaCode(sample[i], place[i]);
  for (size_t i = 0; i < count; ++i) {
    if (delta[i] != kEscape) continue;
    bits.put(static_cast<uint32_t>(sample[i] & 0x7ffffffu), kEscapedBits);
    bits.put(static_cast<uint32_t>(sample[i] >> kEscapedBits & 0x7ffffffu), kEscapedBits);
  }
}

void takeDeltas(std::span<const uint8_t> deltas, std::span<PackedSample> positions, BitReader& bits) {
  const uint8_t* const delta = deltas.data();
  PackedSample* const position = positions.data();
  const size_t count = deltas.size();
  for (size_t i = 0; i < count; ++i) position[i] = moved(position[i], delta[i]);
  for (size_t i = 0; i < count; ++i) {
    if (delta[i] != kEscape) continue;
    const uint64_t low = bits.take(kEscapedBits);
    position[i] = low | static_cast<uint64_t>(bits.take(kEscapedBits)) << kEscapedBits;
  }
}

}  // namespace warpscope
