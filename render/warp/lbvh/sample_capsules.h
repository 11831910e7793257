// Samples drawn out along their rays, as far as their depths are uncertain. For host and device.
// After Zellmann 2020, section 6, which proposes samples that are "smeared out across some interval": of the frame's plane kSpreadPlane, to both sides of the depth.
#pragma once

#include "render/core/sample.h"

namespace warpscope {

/// The half of the line of a sample: along the ray of its pixel, away from the frame's eye, `factor` times as long as `spread` (volume units; 0 for what is no length). Not longer than
/// half the way from the eye, and not than the bounds.
WARPSCOPE_HD inline glm::vec3 halfLineOf(const SampleGrid& grid, PackedSample sample, float spread, float factor) {
  const glm::vec2 offset = grid.pixels.offsetOf(columnOf(sample), rowOf(sample));
  const glm::vec3 toPlane = grid.pixels.forward + offset.x * grid.pixels.right + offset.y * grid.pixels.up;
  const float stretch = std::sqrt(glm::dot(toPlane, toPlane));
  const glm::vec3 extent = grid.bounds.extent();
  const float distance = (grid.pixels.nearDepth + decodeDepth(depthCode(sample), grid.depthStep)) * stretch;
  const float length = minOf(maxOf(factor * spread, 0.0f), minOf(0.5f * distance, std::sqrt(glm::dot(extent, extent))));
  return length / stretch * toPlane;
}

}  // namespace warpscope
