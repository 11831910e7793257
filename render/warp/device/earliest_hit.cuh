// A quick bound of where a ray meets a sphere: what it rules out needs no exact test.
// The perpendicular-distance test of core/ray_sphere.h, with fused arithmetic and an approximate root on a sphere made a little larger.
#pragma once

#include "render/core/camera.h"

namespace warpscope {

/// The square of a sphere's radius, so much larger that earliestHit() is below what intersectSphere finds: with q = 2^-18 times the centre's
/// distance, r^2 + q (r + q). Its root exceeds that of r^2, less what single precision loses of the squared distance from the ray, by at
/// least q / 4, which is sixteen roundings of the distance; the distance along the ray, its root, intersectSphere's result and the
/// direction of quickDirection() together lose less.
__device__ inline float widenedSquare(float distance, float radius) {
  const float q = distance * (1.0f / 262144.0f);
  return fmaf(q, radius + q, radius * radius);
}

/// The direction of pixelRay through the centre of a pixel, but for four roundings or so.
__device__ inline glm::vec3 quickDirection(const Camera& camera, float edge, uint32_t x, uint32_t y) {
  const float right = (static_cast<float>(x) + 0.5f - 0.5f * static_cast<float>(camera.width)) * edge;
  const float up = (0.5f * static_cast<float>(camera.height) - (static_cast<float>(y) + 0.5f)) * edge;
  const auto component = [&](int axis) { return fmaf(right, camera.right[axis], fmaf(up, camera.up[axis], camera.forward[axis])); };
  const glm::vec3 direction(component(0), component(1), component(2));
  return direction * rsqrtf(fmaf(direction.x, direction.x, fmaf(direction.y, direction.y, direction.z * direction.z)));
}

/// At most the distance at which the ray in `direction` meets the sphere; NaN if it passes it.
__device__ inline float earliestHit(const glm::vec3& direction, const float4& sphere) {
  const float along = fmaf(sphere.x, direction.x, fmaf(sphere.y, direction.y, sphere.z * direction.z));
  const float x = fmaf(-along, direction.x, sphere.x), y = fmaf(-along, direction.y, sphere.y), z = fmaf(-along, direction.z, sphere.z);
  const float discriminant = fmaf(-x, x, fmaf(-y, y, fmaf(-z, z, sphere.w)));
  float root;
  asm("sqrt.approx.f32 %0, %1;" : "=f"(root) : "f"(discriminant));
  return along - root;
}

}  // namespace warpscope
