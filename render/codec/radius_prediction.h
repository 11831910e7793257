// What radius code a sample should have, from what else is known of it: by its frame's rule for radii (sample_radius.h).
#pragma once

#include "render/march/march_setup.h"

namespace warpscope {

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
  /// Whether the rule asks for what is not sent beside: radii are like those around them.
  bool isAsBefore() const { return isAsBefore_; }
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

}  // namespace warpscope
