// Depths of boxes, and the near plane.
// See pixel_grid.h.
#include "render/core/pixel_grid.h"

#include <algorithm>
#include <cmath>

#include "render/core/rounding.h"

namespace warpscope {

DepthRange depthRangeOf(const Camera& camera, const Box& bounds) {
  if (bounds.isEmpty()) return {};
  // The third coordinate in the camera's own basis, which rounding has left not quite orthonormal.
  const glm::dvec3 eye(camera.eye), forward(camera.forward);
  const glm::dvec3 across = glm::cross(glm::dvec3(camera.right), glm::dvec3(camera.up));
  const glm::dvec3 normal = across / glm::dot(forward, across);
  double least = 0.0, largest = 0.0, reach = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double lower = static_cast<double>(bounds.lower[axis]), upper = static_cast<double>(bounds.upper[axis]);
    const double a = normal[axis] * (lower - eye[axis]), b = normal[axis] * (upper - eye[axis]);
    least += std::min(a, b);
    largest += std::max(a, b);
    reach += std::max(std::abs(lower), std::abs(upper));
  }
  if (!(largest > 0.0)) return {};
  // What rounding moves the plane and the rays' beginnings on it.
  const glm::dvec3 anchor = glm::abs(eye + std::max(least, 0.0) * forward);
  const double margin = 0x1p-20 * (anchor.x + anchor.y + anchor.z + reach);
  DepthRange range;
  range.nearDepth = std::max(roundedDown(least - margin), 0.0f);
  range.farDepth = std::max(roundedUp(largest + margin), range.nearDepth);
  return range;
}

PixelGrid makePixelGrid(const Camera& camera, float nearDepth) {
  PixelGrid grid;
  grid.anchor = glm::vec3(glm::dvec3(camera.eye) + static_cast<double>(nearDepth) * glm::dvec3(camera.forward));
  grid.right = camera.right;
  grid.up = camera.up;
  grid.forward = camera.forward;
  grid.edge = pixelEdge(camera);
  grid.halfWidth = 0.5f * static_cast<float>(camera.width);
  grid.halfHeight = 0.5f * static_cast<float>(camera.height);
  grid.nearDepth = nearDepth;
  return grid;
}

}  // namespace warpscope
