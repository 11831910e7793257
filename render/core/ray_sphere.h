// First intersection of a ray with a sphere, by the perpendicular distance of the centre from the ray.
// After Haines, Guenther, Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems 2019, chapter 7.
#pragma once

#include <cmath>
#include <limits>

#include "render/core/ray.h"

namespace warpscope {

/// Returned where there is no hit: compares greater than every distance.
inline constexpr float kNoHit = std::numeric_limits<float>::infinity();

/// What intersectSphere is off by, u = 2^-24: the point at t lies within the first of the surface, relative to the
/// centre's distance and the radius seen; t itself is within the second, relative to t, for rays that pass within half
/// the radius of the centre. (Near the outline the surface is nearly parallel to the ray, and t as good as the square
/// root of the first.) To first order the roundings add up to 16u where all fall the same way; half of that is nearly
/// twice what millions of rays of all magnitudes have shown.
inline constexpr double kSphereSurfaceError = 8 * 0x1p-24;
inline constexpr double kSphereDistanceError = 8 * 0x1p-24;

/// The radius of a sphere as an eye sees it that has the centre at this squared distance: at most half the distance, so that no eye is ever inside and
/// no sphere fills more than 30 degrees around its centre. Where the eye comes close to samples they give way, each to its own direction, instead of
/// hiding all others, or of being looked through where there is matter.
WARPSCOPE_HD inline float seenRadius(float squaredDistance, float radius) {
  return radius > 0.0f && 4.0f * radius * radius > squaredDistance ? 0.5f * std::sqrt(squaredDistance) : radius;
}

/// A sphere as all rays from one origin see it.
struct SeenSphere {
  float radius;   ///< seenRadius
  float outside;  ///< squared distance of the centre less squared radius
};

WARPSCOPE_HD inline SeenSphere seenSphere(const glm::vec3& toCenter, float radius) {
  const float squaredDistance = glm::dot(toCenter, toCenter);
  const float seen = seenRadius(squaredDistance, radius);
  return {seen, squaredDistance - seen * seen};
}

/// intersectSphere for the ray that leaves its origin in `direction` (unit); `toCenter` leads from there to the centre, `radius` and `outside` are
/// those of seenSphere.
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

/// Distance along `ray` (unit direction) to where it enters the sphere, taken as large as it is seen (seenRadius), or
/// kNoHit. Spheres around the origin itself, those behind it and those with radius <= 0 are no hits. Never NaN for
/// finite input. As precise as kSphereSurfaceError and kSphereDistanceError say for distances and radii from 2^-50 to
/// 2^57, whose squares are ordinary floats; beyond, spheres may be missed.
WARPSCOPE_HD inline float intersectSphere(const Ray& ray, const glm::vec3& center, float radius) {
  const glm::vec3 toCenter = center - ray.origin;
  const SeenSphere seen = seenSphere(toCenter, radius);
  return intersectSphereFromOrigin(ray.direction, toCenter, seen.radius, seen.outside);
}

}  // namespace warpscope
