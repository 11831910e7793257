// Radii as expected, and what differs from that.
// See radius_tokens.h.
#include "render/codec/radius_tokens.h"

#include <algorithm>

#include "render/codec/zstd_section.h"
#include "render/march/march_setup.h"

namespace warpscope {
namespace {

/// What a sample's radius should be, from what else is known of it.
class RadiusPrediction {
 public:
  explicit RadiusPrediction(const SampleFrame& frame)
      : rule_(sampleRuleOf(frame)),
        edge_(pixelEdge(frame.camera)),
        isAsBefore_(rule_.policy == RadiusPolicy::uncertainty),
        same_(code(0, 0)),
        // Near its eye samples are smaller: sampleRadius().
        isSame_((rule_.policy == RadiusPolicy::voxel || rule_.policy == RadiusPolicy::constant) && code(kDepthCodeMax, 0) == same_) {}

  /// `before`: the code of the sample before this one.
  uint32_t operator()(PackedSample position, Rgba8 color, uint32_t before) const {
    if (isAsBefore_) return before;
    return isSame_ ? same_ : code(depthCode(position), color);
  }
  bool isSame() const { return isSame_; }
  uint32_t same() const { return same_; }

 private:
  uint32_t code(uint32_t depth, Rgba8 color) const {
    return radiusCodeFor(rule_, edge_, depth, static_cast<float>(color >> 24) / 255.0f, 0.0f);
  }

  SampleRule rule_;
  float edge_;
  bool isAsBefore_;
  uint32_t same_;  // at the near plane
  bool isSame_;    // for all samples
};

}  // namespace

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
