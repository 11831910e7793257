// The light of what was lit for one camera, for another: normals are sent, and colours are divided by what light made of them and multiplied by what it makes
// now. For host and device. Ratios of lit pictures: Liu, Shan, Zhang 2001 ("Expressive expression mapping with ratio images").
#pragma once

#include "render/core/normal_code.h"
#include "render/effects/shading.h"

namespace warpscope {

/// Whether what light makes of a place depends on where the eye is: where lights go with it or there are highlights.
inline bool dependsOnEye(const ShadingSetup& setup) {
  if (!setup.isLit) return false;
  bool moves = setup.hasHighlights;
  for (int i = 0; i < setup.lightCount; ++i) {
    const LightKind kind = setup.lights[i].kind;
    moves = moves || (setup.hasDiffuse && (kind == LightKind::headlight || kind == LightKind::camera));
  }
  return moves;
}

/// Of a gradient as gradientOf() gives it; 0 where there is no surface.
WARPSCOPE_HD inline NormalCode normalOf(const ShadingSetup& setup, const float (&gradient)[3]) {
  const glm::vec3 scaled(gradient[0] * setup.gradientScale.x, gradient[1] * setup.gradientScale.y, gradient[2] * setup.gradientScale.z);
  return glm::dot(scaled, scaled) > setup.noiseSquared ? encodeNormal(scaled) : NormalCode{0};
}

/// What the setup's lights make of a place (in volume space) with that normal, seen from where `toEye` (unit) points. `setup`: for gradients of any length.
WARPSCOPE_HD inline LightFactors<float> factorsOf(const ShadingSetup& setup, NormalCode normal, const glm::vec3& toEye, const glm::vec3& place) {
  const glm::vec3 direction = decodeNormal(normal);
  return lightFactors(setup, {direction.x, direction.y, direction.z}, {toEye.x, toEye.y, toEye.z}, {place.x, place.y, place.z});
}

/// What a colour (straight) was before light made this of it, and back. Light that leaves less than this of a colour is taken to leave as much.
inline constexpr float kLeastKept = 1.0f / 64;
WARPSCOPE_HD inline glm::vec3 unlit(const LightFactors<float>& factors, const glm::vec3& color) {
  return (color - glm::vec3(factors.white)) * (1.0f / maxOf(factors.kept, kLeastKept));
}
WARPSCOPE_HD inline glm::vec3 relit(const LightFactors<float>& factors, const glm::vec3& color) {
  return maxOf(factors.kept, kLeastKept) * color + glm::vec3(factors.white);
}

}  // namespace warpscope
