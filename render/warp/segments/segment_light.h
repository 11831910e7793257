// The light of a field's segments, for the camera that draws it. For host and device.
// See relight.h.
#pragma once

#include "render/effects/relight.h"
#include "render/warp/segments/segment_field.h"

namespace warpscope {

/// What lights, as a camera at `eye` has them, make of a segment of that normal, which is not 0. `behind`: SegmentField::places.
WARPSCOPE_HD inline LightFactors<float> lightOf(float behind, NormalCode normal, const PixelGrid& pixels, uint32_t column, uint32_t row,
                                                const ShadingSetup& lights, const glm::vec3& eye) {
  const glm::vec3 place = pixels.at(column, row, behind), way = eye - place;
  return factorsOf(lights, normal, way * (1.0f / sqrtOf(glm::dot(way, way))), place);
}

/// The colour of a segment in that light; `color`: without any.
WARPSCOPE_HD inline glm::vec3 relitColor(const LightFactors<float>& factors, const glm::vec3& color) {
  const glm::vec3 lit = relit(factors, color);
  return {maxOf(lit.x, 0.0f), maxOf(lit.y, 0.0f), maxOf(lit.z, 0.0f)};
}

}  // namespace warpscope
