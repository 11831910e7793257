// Which pixels can see what of a sample's sphere lies in the sample's own pixel of its frame? Far fewer than see the sphere, for host and device.
// That piece is a stretch of the sample's ray, as wide as the pixel is where the sphere ends: it lies between two small spheres around the stretch's ends.
#pragma once

#include <initializer_list>

#include "render/warp/splats/sphere_footprint.h"

namespace warpscope {

/// What the dot products of a frame camera's basis may be off by for pieceFootprint().
inline constexpr float kBasisError = 1e-6f;

/// Whether they are not off by more.
inline bool isOrthonormal(const Camera& camera) {
  const auto isOff = [](const glm::vec3& a, const glm::vec3& b, double product) { return !(std::abs(glm::dot(glm::dvec3(a), glm::dvec3(b)) - product) <= kBasisError); };
  return !isOff(camera.right, camera.right, 1.0) && !isOff(camera.up, camera.up, 1.0) && !isOff(camera.forward, camera.forward, 1.0) && !isOff(camera.right, camera.up, 0.0) &&
         !isOff(camera.right, camera.forward, 0.0) && !isOff(camera.up, camera.forward, 0.0);
}

/// Every pixel whose ray meets the piece (pieceDistance() of surface_hits.h) is inside, rounding included, and inside `whole`, the footprint of `sphere`, which is the sample's at its place
/// but of any radius. `origin` leads from the eye of the frame, whose camera isOrthonormal(), to that of `view`. `whole` itself where one of the small spheres is near the eye, not wholly in
/// front of the eye's plane or outside the picture, for samples that do not lie on their ray, and where squares of distances leave float's range.
WARPSCOPE_HD inline PixelRect pieceFootprint(const FootprintView& view, const SampleGrid& grid, PackedSample sample, const glm::vec3& origin, const Sphere& sphere, const PixelRect& whole) {
  constexpr float kHalfDiagonal = 0.70710678f * 1.02f;  // of a square, and some roundings more
  constexpr float kPlaneError = 8.0f * kBasisError;     // of the pixel's planes and the place of the ray, relative to distances from the eyes and the coordinates' origin
  const float depth = decodeDepth(depthCode(sample), grid.depthStep);
  if (whole.isEmpty() || sphere.center != grid.pixels.at(columnOf(sample), rowOf(sample), depth)) return whole;
  const glm::vec3 toCenter = sphere.center - view.eye, fromFrame = toCenter + origin;
  const auto lengthOf = [](const glm::vec3& v) { return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z); };
  const float halfWidth = kHalfDiagonal * grid.pixels.edge * (grid.pixels.nearDepth + depth + sphere.radius) +
                          kPlaneError * (lengthOf(origin) + lengthOf(toCenter) + lengthOf(sphere.center) + sphere.radius);
  constexpr float kFarthest = 0x1p57f, kNearest = 0x1p-50f;  // as intersectSphere's
  const float distance = std::sqrt(glm::dot(fromFrame, fromFrame));
  if (!(distance < kFarthest && distance > kNearest && lengthOf(toCenter) < kFarthest)) return whole;
  const glm::vec3 stretch = sphere.radius / distance * fromFrame;
  PixelRect rect{whole.x1, whole.y1, whole.x0, whole.y0};
  for (const float side : {-1.0f, 1.0f}) {
    const glm::vec3 offset = side * stretch, toEnd = toCenter + offset;
    if (!(glm::dot(toEnd, toEnd) > 16.0f * halfWidth * halfWidth)) return whole;  // seenRadius() would make it smaller
    if (!(glm::dot(view.depth, toEnd) > 1.001f * halfWidth)) return whole;        // from there on rectangles of the ends hold what lies between them
    const PixelRect part = sphereFootprint(view, {sphere.center + offset, halfWidth});
    if (part.isEmpty()) return whole;
    rect = {minOf(rect.x0, part.x0), minOf(rect.y0, part.y0), maxOf(rect.x1, part.x1), maxOf(rect.y1, part.y1)};
  }
  return {maxOf(rect.x0, whole.x0), maxOf(rect.y0, whole.y0), minOf(rect.x1, whole.x1), minOf(rect.y1, whole.y1)};
}

}  // namespace warpscope
