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

/// What each component of pixelRay's direction is off by, at most: 3 roundings of the place on the image plane, 3 of
/// what is added up there, and 6 of making it a unit, relative to 1; also by how much its length differs from 1.
inline constexpr double kRayDirectionError = 12 * 0x1p-24;

/// The ray through the image point `pixel` (pixel centres at +0.5). Its direction has unit length, both within
/// kRayDirectionError.
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

/// What project() is off by, with d the point's distance from the eye, z its forward depth, e = pixelEdge() and q the
/// pixel's distance from the image's centre along each axis: forwardDepth by 4u d (offset, products, sums; u = 2^-24),
/// each coordinate of the pixel by kProjectError (d / z) (1 / e + q) and a u of the image's size. That is pixels where
/// d / z is large: a point hardly in front of the eye's plane is anywhere at the border.
inline constexpr double kForwardDepthError = 4.001 * 0x1p-24;
inline constexpr double kProjectError = 8 * 0x1p-24;

/// Projects `point`; `pixel` is meaningless where forwardDepth <= 0. As precise as kForwardDepthError and kProjectError
/// say.
WARPSCOPE_HD inline Projection project(const Camera& camera, const glm::vec3& point) {
  const glm::vec3 offset = point - camera.eye;
  const float depth = glm::dot(offset, camera.forward);
  const float scale = 1.0f / (depth * pixelEdge(camera));
  return {{0.5f * static_cast<float>(camera.width) + glm::dot(offset, camera.right) * scale,
           0.5f * static_cast<float>(camera.height) - glm::dot(offset, camera.up) * scale},
          depth};
}

/// What each clip coordinate is off by, relative to the distances of eye and point from the coordinates' origin, times
/// its scale (1 / tanHalfFovY for y, for x times height / width, 1 for w): 7 roundings of the matrix's entries, 4 of
/// the product. Unlike project() it cancels what eye and point have in common after rounding it: rasterisers are for
/// eyes about as far away as the volume is large.
inline constexpr double kClipError = 11.001 * 0x1p-24;

/// Projection for rasterisers: clip coordinates with y up and depth z / w = nearDepth / forwardDepth in [0, 1], 1 at
/// `nearDepth`, 0 at infinity ("reverse Z": with a float depth buffer the resolution is relative to depth). Agrees with
/// project() within kClipError.
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
