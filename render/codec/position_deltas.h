// What positions differ in from the places that stand for them: a byte each, and the whole position where a byte is too
// little.
#pragma once

#include <cstdint>
#include <span>

#include "render/codec/tokens.h"
#include "render/core/sample.h"

namespace warpscope {

/// The most bits that a position takes beside its byte.
inline constexpr uint32_t kMostDeltaBits = 54;

/// Fills `deltas`, a byte for each sample; positions that a byte cannot say go to `bits`. As many samples as places and
/// deltas.
void putDeltas(std::span<const PackedSample> samples, std::span<const PackedSample> places, std::span<uint8_t> deltas,
               BitWriter& bits);

/// Moves places to positions, whatever the bytes and bits are. As many deltas as positions.
void takeDeltas(std::span<const uint8_t> deltas, std::span<PackedSample> positions, BitReader& bits);

}  // namespace warpscope
