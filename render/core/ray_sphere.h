// First intersection of a ray with a sphere, by the perpendicular distance of the centre from the ray.
// After Haines, Guenther, Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems 2019, chapter 7.
#pragma once

#include <cmath>
#include <limits>

#include "render/core/ray.h"

namespace warpscope {

/// Returned where there is no hit: compares greater than every distance.
inline constexpr float kNoHit = std::numeric_limits<float>::infinity();

/// By how much the eye is outside a sphere: squared distance of the centre less squared radius; the same for all rays from one origin.
WARPSCOPE_HD inline float outsideSphere(const glm::vec3& toCenter, float radius) {
  return glm::dot(toCenter, toCenter) - radius * radius;
}

/// intersectSphere for the ray that leaves its origin in `direction` (unit); `toCenter` leads from there to the centre, and `outside` is
/// outsideSphere of both.
WARPSCOPE_HD inline float intersectSphereFromOrigin(const glm::vec3& direction, const glm::vec3& toCenter, float radius, float outside) {
  const float along = glm::dot(toCenter, direction);
  if (!(along > 0.0f) || !(radius > 0.0f)) return kNoHit;
  // From the ray's closest point to the centre: its length is compared, not the difference of two large squares.
  const glm::vec3 offset = toCenter - along * direction;
  const float discriminant = radius * radius - glm::dot(offset, offset);
  if (!(discriminant >= 0.0f) || !(outside > 0.0f)) return kNoHit;
  // along - sqrt(discriminant) cancels where the surface is near the origin; the product of the two roots does not. Yet for an origin
  // within rounding of the surface and a tangent ray, `outside` is noise and `along` may be far smaller: the first root is never
  // beyond the closest point.
  const float t = outside / (along + std::sqrt(discriminant));
  return t > along ? along : t;
}

/// Distance along `ray` (unit direction) to where it enters the sphere, or kNoHit.
/// A sphere that holds the origin, or whose surface does, is no hit: an eye inside a splat looks through it instead of seeing
/// nothing but its colour. Spheres behind the origin and those with radius <= 0 are no hits. Never NaN for finite input.
WARPSCOPE_HD inline float intersectSphere(const Ray& ray, const glm::vec3& center, float radius) {
  const glm::vec3 toCenter = center - ray.origin;
  return intersectSphereFromOrigin(ray.direction, toCenter, radius, outsideSphere(toCenter, radius));
}

}  // namespace warpscope
