// Ray and sphere as textbooks print it, and policies that tell it from ray_sphere.h at compile time.
// The quadratic formula in single precision (e.g. Glassner 1989, chapter 2); wrong where the sphere is small against its distance.
#pragma once

#include <cmath>

#include "render/core/arithmetic.h"
#include "render/core/ray_sphere.h"

namespace warpscope {

/// The nearer root of a t^2 + b t + c, from b^2 - 4ac; kNoHit where there is none in front of the origin. What surrounds
/// the origin is not seen.
WARPSCOPE_HD inline float intersectSphereTextbook(const Ray& ray, const glm::vec3& center, float radius) {
  const glm::vec3 fromCenter = ray.origin - center;
  const float a = glm::dot(ray.direction, ray.direction);
  const float b = 2.0f * glm::dot(fromCenter, ray.direction);
  const float c = glm::dot(fromCenter, fromCenter) - radius * radius;
  const float discriminant = b * b - 4.0f * a * c;
  if (!(discriminant >= 0.0f)) return kNoHit;
  const float t = (-b - std::sqrt(discriminant)) / (2.0f * a);
  return t > 0.0f ? t : kNoHit;
}

struct StableSphere {
  WARPSCOPE_HD static float intersect(const Ray& ray, const glm::vec3& center, float radius) {
    return intersectSphere(ray, center, radius);
  }
};

struct TextbookSphere {
  WARPSCOPE_HD static float intersect(const Ray& ray, const glm::vec3& center, float radius) {
    return intersectSphereTextbook(ray, center, radius);
  }
};

/// Calls `f` with the policy.
template <class F>
decltype(auto) visitSphereArithmetic(Arithmetic arithmetic, F&& f) {
  if (arithmetic == Arithmetic::textbook) return f(TextbookSphere{});
  return f(StableSphere{});
}

}  // namespace warpscope
