// The rays of a picture's pixels, from a plane in front of what is looked at.
// Counted from the eye, distances along rays would lose a bit each time that the camera is twice as far away; counted from that plane they
// are of the size of what is looked at, wherever the eye is.
#pragma once

#include <cmath>

#include "render/core/box.h"
#include "render/core/camera.h"

namespace warpscope {

/// Forward depths of a box: distances from the eye's plane, volume units.
struct DepthRange {
  float nearDepth = 0.0f;  ///< at most the least one of any point, so little less that it is about that; 0 where that is behind the eye
  float farDepth = 0.0f;   ///< at least the largest one of any point; at least nearDepth
};

/// The depths of `bounds`, which are finite, seen by a camera that isUsable(). Both 0 for an empty box and one behind the eye. With the least
/// depth as PixelGrid::nearDepth no ray begins inside the box unless the eye is as near, rounding of the plane included.
DepthRange depthRangeOf(const Camera& camera, const Box& bounds);

/// A ray of a pixel.
struct PixelRay {
  Ray ray;       ///< begins on the near plane
  float cosine;  ///< forward depth behind the near plane for each unit along the ray
};

/// What PixelGrid::at is off by, relative to the size of what it adds up.
inline constexpr double kPositionError = 0x1p-21;

/// What the rays of a camera's pixels share. Made once for a picture; plain data, for host and device.
struct PixelGrid {
  glm::vec3 anchor{0.0f};  ///< straight in front of the eye, on the near plane
  glm::vec3 right{1.0f, 0.0f, 0.0f};
  glm::vec3 up{0.0f, 1.0f, 0.0f};
  glm::vec3 forward{0.0f, 0.0f, -1.0f};
  float edge = 0.0f;  ///< pixelEdge()
  float halfWidth = 0.0f, halfHeight = 0.0f;  ///< of the picture, pixels
  float nearDepth = 0.0f;                     ///< forward depth of the near plane

  /// From the axis to the pixel's centre, on the plane at distance 1 from the eye: coordinates along `right` and `up`.
  WARPSCOPE_HD glm::vec2 offsetOf(uint32_t column, uint32_t row) const {
    return {(static_cast<float>(column) + 0.5f - halfWidth) * edge, (halfHeight - (static_cast<float>(row) + 0.5f)) * edge};
  }

  /// The part of pixelRay() through the pixel's centre that lies behind the near plane; the directions are the same bits.
  WARPSCOPE_HD PixelRay ray(uint32_t column, uint32_t row) const {
    const glm::vec2 offset = offsetOf(column, row);
    const glm::vec3 toPlane = forward + offset.x * right + offset.y * up;
    const float cosine = 1.0f / std::sqrt(glm::dot(toPlane, toPlane));
    return {{anchor + nearDepth * (offset.x * right + offset.y * up), toPlane * cosine}, cosine};
  }

  /// The point of the pixel's ray whose forward depth is that of the near plane and `behind` more.
  ///
  /// Each coordinate is within kPositionError (|anchor| + behind + l) of the point of the given camera and near plane
  /// in exact arithmetic, with l the distance of the point from the camera's axis: no term of it grows with the
  /// distance of the eye alone.
  WARPSCOPE_HD glm::vec3 at(uint32_t column, uint32_t row, float behind) const {
    const glm::vec2 offset = offsetOf(column, row);
    return anchor + behind * forward + (nearDepth + behind) * (offset.x * right + offset.y * up);
  }
};

/// The grid of a camera whose rays begin at the forward depth `nearDepth`, 0 or more. The near plane's place is computed in double and rounded
/// once. Host only. Any camera will do; unusable ones give useless rays.
PixelGrid makePixelGrid(const Camera& camera, float nearDepth);

}  // namespace warpscope
