// Distance along a ray to the first intersection with a capsule: a sphere drawn out along a line. For host and device.
// A capsule is all spheres of one radius about the points of its line. Which of them a ray meets first has a closed form, and that one is met as ray_sphere.h does: distances
// from the ray are compared (Haines, Guenther, Akenine-Moeller, Ray Tracing Gems 2019, chapter 7), never roots of b^2 - 4ac, which rays along the line would leave without a digit.
#pragma once

#include "render/core/numeric.h"
#include "render/core/ray_sphere.h"

namespace warpscope {

/// What intersectCapsule is off by: the point at t lies within this of the surface, relative to the middle's distance, the line's half and the radius. More roundings than of a sphere
/// add up; millions of rays of all magnitudes have shown 6.4 of these 16.
inline constexpr double kCapsuleSurfaceError = 16 * 0x1p-24;

/// A capsule as all rays from one origin see it: about `toCenter + s * half` for s in [-1, 1], `toCenter` from there.
struct SeenCapsule {
  glm::vec3 half{0.0f};
  float radius = 0.0f;  ///< as seenRadius makes it of the point of the line that is nearest to the origin: no eye is ever inside
};

WARPSCOPE_HD inline SeenCapsule seenCapsule(const glm::vec3& toCenter, const glm::vec3& half, float radius) {
  const float squaredLength = glm::dot(half, half);
  const float nearest = squaredLength > 0.0f ? minOf(maxOf(-glm::dot(toCenter, half) / squaredLength, -1.0f), 1.0f) : 0.0f;
  const glm::vec3 toNearest = toCenter + nearest * half;
  return {half, seenRadius(glm::dot(toNearest, toNearest), radius)};
}

/// intersectCapsule for the ray that leaves its origin in `direction` (unit).
///
/// Along the ray, of the sphere about s: a + c s - sqrt(r^2 - |o + s v|^2), with c and v the parts of the line's half along the ray and across, a and o those of its middle. It is
/// convex in s: the least is where its slope is 0, or at the end nearest to that. With the point of the line nearest to the ray at s', at the distance d, that place is
/// s' - sqrt(r^2 - d^2) c / (|v| |half|).
WARPSCOPE_HD inline float intersectCapsuleFromOrigin(const glm::vec3& direction, const glm::vec3& toCenter, const SeenCapsule& capsule) {
  const float squaredRadius = capsule.radius * capsule.radius;
  const float along = glm::dot(capsule.half, direction);
  const glm::vec3 across = capsule.half - along * direction;
  const float breadth = std::sqrt(glm::dot(across, across));
  const glm::vec3 offset = toCenter - glm::dot(toCenter, direction) * direction;
  float nearest = 0.0f;                          // of the line to the ray
  float first = along > 0.0f ? -1.0f : 1.0f;     // of the spheres along the ray, where it runs along the line
  if (breadth > 0.0f) {
    const glm::vec3 unit = across / breadth;
    const float toward = glm::dot(offset, unit);
    const glm::vec3 apart = offset - toward * unit;
    const float depth = std::sqrt(maxOf(squaredRadius - glm::dot(apart, apart), 0.0f));
    nearest = minOf(maxOf(-toward / breadth, -1.0f), 1.0f);
    first = minOf(maxOf((-toward - depth * along / std::sqrt(along * along + breadth * breadth)) / breadth, -1.0f), 1.0f);
  }
  const glm::vec3 passed = offset + nearest * across;
  if (!(squaredRadius - glm::dot(passed, passed) >= 0.0f) || !(capsule.radius > 0.0f)) return kNoHit;
  const glm::vec3 toFirst = toCenter + first * capsule.half;
  const float toPoint = glm::dot(toFirst, direction);
  const float outside = glm::dot(toFirst, toFirst) - squaredRadius;
  if (!(toPoint > 0.0f) || !(outside > 0.0f)) return kNoHit;
  // As intersectSphereFromOrigin; but for rounding, the ray meets that sphere if it meets the capsule.
  const glm::vec3 beside = toFirst - toPoint * direction;
  const float t = outside / (toPoint + std::sqrt(maxOf(squaredRadius - glm::dot(beside, beside), 0.0f)));
  return t > toPoint ? toPoint : t;
}

/// Distance along `ray` (unit direction) to where it enters the capsule about `center - half` to `center + half`, its radius as large as it is seen (SeenCapsule), or kNoHit. Those
/// behind the origin and those with radius <= 0 are no hits. Without a length it is intersectSphere, bit for bit. As precise as kCapsuleSurfaceError says within the magnitudes that
/// intersectSphere names.
WARPSCOPE_HD inline float intersectCapsule(const Ray& ray, const glm::vec3& center, const glm::vec3& half, float radius) {
  const glm::vec3 toCenter = center - ray.origin;
  return intersectCapsuleFromOrigin(ray.direction, toCenter, seenCapsule(toCenter, half, radius));
}

}  // namespace warpscope
