// How large the spheres of a frame's samples have to be, so that those of one surface just touch. For host and device.
// A frame's own radii let spheres of neighbours overlap by far: several of them lie along a ray where there is one surface. Half as large as the farthest neighbour is away they close the
// surface as well, as the discs of surfels do (Pfister, Zwicker, van Baar, Gross 2000, "Surfels", section 7); neighbours too far away for the frame's own spheres to touch are of another
// surface.
#pragma once

#include "render/core/camera.h"
#include "render/core/sample.h"

namespace warpscope {

/// A frame's samples, and where each pixel's ray begins among them. The memory is another's.
struct SampleRays {
  const PackedSample* samples = nullptr;
  const uint8_t* layers = nullptr;    ///< kLayerPlane; null where every sample is its ray's only one
  const uint32_t* firstOf = nullptr;  ///< width * height, row by row, as ownPicture() has them
  uint32_t count = 0;                 ///< of samples
  uint32_t width = 0, height = 0;     ///< of the frame's picture
  SampleGrid grid;

  /// The pixel's first sample, kNoSample where it has none. The pixel is in the picture.
  WARPSCOPE_HD uint32_t firstSample(uint32_t column, uint32_t row) const {
    const uint32_t first = firstOf[size_t{row} * width + column];
    return first < count ? first : kNoSample;
  }
  /// Of the samples of the ray that begins at `first`, the one at the nearest depth.
  WARPSCOPE_HD uint32_t nearestOfRay(uint32_t first, uint32_t depth) const {
    uint32_t nearest = first, leastApart = ~0u;
    for (uint32_t i = first; i < count && (i == first || (layers != nullptr && layers[i] != 0)); ++i) {
      const uint32_t other = depthCode(samples[i]), apart = depth < other ? other - depth : depth - other;
      if (apart >= leastApart) continue;
      leastApart = apart;
      nearest = i;
    }
    return nearest;
  }
};

/// So much larger than they need be, relative to themselves, radii are made: more than rounding one to its code takes away.
inline constexpr float kRadiusSlack = 1.02f;
static_assert(kRadiusSlack * (1.0 - kRadiusCodeError) > 1.0);

/// The sample with a radius that lets its sphere fill its pixel, and reach half way to those of the eight neighbours that its own radius and theirs would let it touch.
WARPSCOPE_HD inline PackedSample withSurfaceRadius(const SampleRays& rays, uint32_t i) {
  constexpr float kHalfDiagonal = 0.70710678f;  // of a square
  const PackedSample sample = rays.samples[i];
  const uint32_t column = columnOf(sample), row = rowOf(sample);
  const Sphere sphere = unpackSample(sample, rays.grid);
  const PixelGrid& pixels = rays.grid.pixels;
  float radius = kHalfDiagonal * pixels.edge * (pixels.nearDepth + decodeDepth(depthCode(sample), rays.grid.depthStep));
  if (column < rays.width && row < rays.height)
    for (uint32_t y = row == 0 ? 0 : row - 1; y <= row + 1 && y < rays.height; ++y)
      for (uint32_t x = column == 0 ? 0 : column - 1; x <= column + 1 && x < rays.width; ++x) {
        const uint32_t first = x == column && y == row ? kNoSample : rays.firstSample(x, y);
        if (first == kNoSample) continue;
        const Sphere neighbour = unpackSample(rays.samples[rays.nearestOfRay(first, depthCode(sample))], rays.grid);
        const glm::vec3 offset = neighbour.center - sphere.center;
        const float distance = std::sqrt(glm::dot(offset, offset));
        if (distance <= sphere.radius + neighbour.radius) radius = maxOf(radius, 0.5f * distance);
      }
  return withRadiusCode(sample, encodeRadius(kRadiusSlack * radius, rays.grid.radiusUnit));
}

/// Whether `point` lies in a pixel of the frame's picture where its camera has seen nothing.
WARPSCOPE_HD inline bool isSeenEmpty(const SampleRays& rays, const Camera& camera, const glm::vec3& point) {
  const Projection at = project(camera, point);
  if (!(at.forwardDepth > 0.0f) || !(at.pixel.x >= 0.0f && at.pixel.x < static_cast<float>(rays.width)) ||
      !(at.pixel.y >= 0.0f && at.pixel.y < static_cast<float>(rays.height)))
    return false;
  return rays.firstSample(static_cast<uint32_t>(at.pixel.x), static_cast<uint32_t>(at.pixel.y)) == kNoSample;
}

}  // namespace warpscope
