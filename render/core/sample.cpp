// How a frame's samples are quantised.
// See sample.h.
#include "render/core/sample.h"

#include <algorithm>
#include <limits>

namespace warpscope {

bool isUsable(const SampleQuantization& quantization) {
  for (int axis = 0; axis < 3; ++axis) {
    const float lower = quantization.bounds.lower[axis], upper = quantization.bounds.upper[axis];
    if (!std::isfinite(lower) || !std::isfinite(upper) || !(lower <= upper)) return false;
  }
  int exponent = 0;
  return quantization.radiusUnit > 0.0f && std::isfinite(quantization.radiusUnit) && std::frexp(quantization.radiusUnit, &exponent) == 0.5f &&
         quantization.nearDepth >= 0.0f && std::isfinite(quantization.nearDepth) && quantization.depthStep > 0.0f &&
         std::isfinite(quantization.depthStep);
}

SampleQuantization quantizationFor(const Camera& camera, const Box& bounds, float radiusUnit) {
  constexpr float kSteps = 0x1p18f;
  const DepthRange depths = depthRangeOf(camera, bounds);
  const float span = depths.farDepth - depths.nearDepth;
  // A flat volume seen from the front has no depth; any step will do.
  return {bounds, radiusUnit, depths.nearDepth, span > 0.0f ? std::max(span / kSteps, std::numeric_limits<float>::min()) : 1.0f};
}

}  // namespace warpscope
