// Axis-aligned boxes, and the slab test of a ray against one.
// After Williams, Barrus, Morley, Shirley 2005. For the ray's part inside a volume; what culls must not lose hits: see lbvh.h.
#pragma once

#include <limits>

#include "render/core/host_device.h"

namespace warpscope {

/// An axis-aligned box. It is empty (nothing is inside) where a lower bound lies above the upper one.
struct Box {
  glm::vec3 lower{std::numeric_limits<float>::infinity()};
  glm::vec3 upper{-std::numeric_limits<float>::infinity()};

  WARPSCOPE_HD glm::vec3 extent() const { return upper - lower; }
  WARPSCOPE_HD glm::vec3 center() const { return 0.5f * lower + 0.5f * upper; }
  WARPSCOPE_HD bool isEmpty() const { return !(lower.x <= upper.x && lower.y <= upper.y && lower.z <= upper.z); }
  WARPSCOPE_HD void include(const glm::vec3& point) {
    lower = glm::min(lower, point);
    upper = glm::max(upper, point);
  }
  WARPSCOPE_HD void include(const Box& other) {
    lower = glm::min(lower, other.lower);
    upper = glm::max(upper, other.upper);
  }
  bool operator==(const Box&) const = default;
};

/// The part of a ray inside a box, as distances along the ray; a miss where tNear > tFar.
struct RayInterval {
  float tNear = 1.0f;
  float tFar = 0.0f;
  WARPSCOPE_HD bool isMiss() const { return !(tNear <= tFar); }
};

/// What the slab test needs of a ray, computed once. The reciprocal of a zero component, of either sign, is +infinity; products with it
/// are infinite of the distance's sign, except 0 * inf, which the test below treats as "on the slab".
struct RayReciprocal {
  glm::vec3 origin;
  glm::vec3 invDirection;
};

/// -0 is made +0 first, so that both zeros take the same path.
WARPSCOPE_HD inline float reciprocalOf(float component) { return 1.0f / (component + 0.0f); }

WARPSCOPE_HD inline RayReciprocal reciprocalOf(const glm::vec3& origin, const glm::vec3& direction) {
  return {origin, {reciprocalOf(direction.x), reciprocalOf(direction.y), reciprocalOf(direction.z)}};
}

/// Shortens the interval to its part between the planes `lower` and `upper` of one axis. `inv` is the direction's reciprocal there.
WARPSCOPE_HD inline void clipToSlab(RayInterval& interval, float origin, float inv, float lower, float upper) {
  const float t0 = ((inv < 0.0f ? upper : lower) - origin) * inv;
  const float t1 = ((inv < 0.0f ? lower : upper) - origin) * inv;
  // Comparisons with NaN (an origin on a slab plane, parallel to it) are false: the bound is left as it is.
  interval.tNear = t0 > interval.tNear ? t0 : interval.tNear;
  interval.tFar = t1 < interval.tFar ? t1 : interval.tFar;
}

/// What an end of intersectBox is off by, relative to itself: one rounding each of the reciprocal, the difference and
/// their product.
inline constexpr double kBoxDistanceError = 3.001 * 0x1p-24;

/// Intersects the ray with `box` within [tMin, tMax] (tMax may be infinite). Its ends are those of the true interval
/// within kBoxDistanceError each. Misses on empty, inverted and NaN boxes. A ray that lies in a face of the box hits
/// it.
WARPSCOPE_HD inline RayInterval intersectBox(const RayReciprocal& ray, const Box& box, float tMin, float tMax) {
  if (box.isEmpty()) return {};
  RayInterval interval{tMin, tMax};
  clipToSlab(interval, ray.origin.x, ray.invDirection.x, box.lower.x, box.upper.x);
  clipToSlab(interval, ray.origin.y, ray.invDirection.y, box.lower.y, box.upper.y);
  clipToSlab(interval, ray.origin.z, ray.invDirection.z, box.lower.z, box.upper.z);
  return interval;
}

}  // namespace warpscope
