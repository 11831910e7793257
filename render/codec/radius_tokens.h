// The radius codes of a layer's samples as tokens and bits: how they differ from what the frame's rule for radii makes
// of depth and opacity; for radii by uncertainty, from the sample before.
#pragma once

#include <cstdint>
#include <span>

#include "render/codec/tokens.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// Fills `tokens`. All spans are of the same samples.
void putRadii(const SampleFrame& frame, std::span<const PackedSample> samples, std::span<const Rgba8> colors,
              std::span<uint8_t> tokens, BitWriter& bits);

/// Puts radius codes into the upper bits of `positions`, whatever the tokens are. Of the colours only opacities are
/// read.
void takeRadii(const SampleFrame& frame, std::span<const uint8_t> tokens, std::span<const Rgba8> colors,
               std::span<PackedSample> positions, BitReader& bits);

}  // namespace warpscope
