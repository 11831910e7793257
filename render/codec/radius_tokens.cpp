// Radii as expected, and what differs from that.
// See radius_tokens.h.
#include "render/codec/radius_tokens.h"

#include <algorithm>

#include "render/codec/radius_prediction.h"
#include "render/codec/zstd_section.h"

namespace warpscope {
void putRadii(const SampleFrame& frame, std::span<const PackedSample> samples, std::span<const Rgba8> colors,
              std::span<uint8_t> tokens, BitWriter& bits) {
  const RadiusPrediction radius(frame);
  const size_t count = tokens.size();
  if (radius.isSame()) {
    uint32_t differing = 0;
    for (size_t i = 0; i < count; ++i) differing |= radiusCode(samples[i]) ^ radius.same();
    if (differing == 0) {
      std::fill(tokens.begin(), tokens.end(), uint8_t{0});
      return;
    }
  }
  uint32_t before = radius.same();
  for (size_t i = 0; i < count; ++i) {
    const auto likely = static_cast<int32_t>(radius(samples[i], colors[i], before));
    before = radiusCode(samples[i]);
    tokens[i] = putToken(zigzag(static_cast<int32_t>(before) - likely), bits);
  }
}

void takeRadii(const SampleFrame& frame, std::span<const uint8_t> tokens, std::span<const Rgba8> colors,
               std::span<PackedSample> positions, BitReader& bits) {
  const RadiusPrediction radius(frame);
  const size_t count = tokens.size();
  PackedSample* const position = positions.data();
  if (radius.isSame() && isZero(tokens)) {
    for (size_t i = 0; i < count; ++i) position[i] = withRadiusCode(position[i], radius.same() & kRadiusCodeMax);
    return;
  }
  BitReader take = bits;  // a local: what is written cannot be what it reads then
  uint32_t before = radius.same();
  for (size_t i = 0; i < count; ++i) {
    const auto likely = radius(position[i], colors[i], before);
    const uint32_t difference = static_cast<uint32_t>(unzigzag(takeToken(tokens[i], take)));
    before = (likely + difference) & kRadiusCodeMax;
    position[i] = withRadiusCode(position[i], before);
  }
  bits = take;
}

}  // namespace warpscope
