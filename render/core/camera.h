// A pinhole camera in volume space. Every convention about pixels, rays and projection that the program uses is stated here.
// Pixel (0,0) is top left, its centre is at (0.5, 0.5). "View depth" is the distance along the pixel's ray, never window z.
#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>

#include "render/core/ray.h"

namespace warpscope {

/// The basis is orthonormal but carries its handedness itself: a volume whose axes form a left-handed system in the world (many
/// medical files) is seen the right way round because `right` is mirrored, not the data.
struct Camera {
  glm::vec3 eye{0.0f, 0.0f, 1.0f};
  glm::vec3 right{1.0f, 0.0f, 0.0f};
  glm::vec3 up{0.0f, 1.0f, 0.0f};
  glm::vec3 forward{0.0f, 0.0f, -1.0f};
  float tanHalfFovY = 0.41421356f;  ///< tangent of half the vertical field of view
  uint32_t width = 0;               ///< pixels
  uint32_t height = 0;              ///< pixels

  bool operator==(const Camera&) const = default;
};
static_assert(std::is_trivially_copyable_v<Camera>);

/// Edge of a pixel on the image plane at distance 1 from the eye.
WARPSCOPE_HD inline float pixelEdge(const Camera& camera) { return 2.0f * camera.tanHalfFovY / static_cast<float>(camera.height); }

/// The ray through the image point `pixel` (pixel centres at +0.5). Its direction has unit length.
WARPSCOPE_HD inline Ray pixelRay(const Camera& camera, const glm::vec2& pixel) {
  const float edge = pixelEdge(camera);
  const float x = (pixel.x - 0.5f * static_cast<float>(camera.width)) * edge;
  const float y = (0.5f * static_cast<float>(camera.height) - pixel.y) * edge;
  return {camera.eye, glm::normalize(camera.forward + x * camera.right + y * camera.up)};
}

/// Where a point appears.
struct Projection {
  glm::vec2 pixel{0.0f};      ///< image position, pixel centres at +0.5
  float forwardDepth = 0.0f;  ///< distance from the eye's plane; the point is visible only where this is positive
};

/// Projects `point`; `pixel` is meaningless where forwardDepth <= 0.
WARPSCOPE_HD inline Projection project(const Camera& camera, const glm::vec3& point) {
  const glm::vec3 offset = point - camera.eye;
  const float depth = glm::dot(offset, camera.forward);
  const float scale = 1.0f / (depth * pixelEdge(camera));
  return {{0.5f * static_cast<float>(camera.width) + glm::dot(offset, camera.right) * scale,
           0.5f * static_cast<float>(camera.height) - glm::dot(offset, camera.up) * scale},
          depth};
}

/// Projection for rasterisers: clip coordinates with y up and depth z / w = nearDepth / forwardDepth in [0, 1], 1 at `nearDepth`, 0 at
/// infinity ("reverse Z": with a float depth buffer the resolution is relative to depth). Agrees with project().
WARPSCOPE_HD inline glm::mat4 clipFromVolume(const Camera& camera, float nearDepth) {
  const float scaleY = 1.0f / camera.tanHalfFovY;
  const float scaleX = scaleY * static_cast<float>(camera.height) / static_cast<float>(camera.width);
  const glm::vec4 x(scaleX * camera.right, -scaleX * glm::dot(camera.right, camera.eye));
  const glm::vec4 y(scaleY * camera.up, -scaleY * glm::dot(camera.up, camera.eye));
  const glm::vec4 w(camera.forward, -glm::dot(camera.forward, camera.eye));
  return glm::transpose(glm::mat4(x, y, glm::vec4(0.0f, 0.0f, 0.0f, nearDepth), w));
}

/// True if the camera can make pictures: finite, a field of view inside (0, 180) degrees, a basis that is one, a size within limits.
bool isUsable(const Camera& camera);

/// Throws InputError unless isUsable(camera).
void requireUsable(const Camera& camera);

}  // namespace warpscope
