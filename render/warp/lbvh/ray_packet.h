// pixelRay and intersectSphere for as many rays at once as a vector register has lanes. Host only.
// The same operations in the same order as core/camera.h and core/ray_sphere.h, so that every lane holds the same bits
// as theirs.
#pragma once

#include <cstdint>
#include <xsimd/xsimd.hpp>

#include "render/core/camera.h"
#include "render/core/ray_sphere.h"

namespace warpscope {

using FloatPack = xsimd::batch<float>;
using FloatMask = xsimd::batch_bool<float>;
inline constexpr uint32_t kPackLanes = FloatPack::size;

struct Vec3Pack {
  FloatPack x, y, z;
};

inline FloatPack dot(const Vec3Pack& a, const Vec3Pack& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// 0, 1, 2, ... one for each lane.
inline FloatPack laneNumbers() {
  alignas(64) float numbers[kPackLanes];
  for (uint32_t i = 0; i < kPackLanes; ++i) numbers[i] = static_cast<float>(i);
  return FloatPack::load_aligned(numbers);
}

/// Directions of pixelRay through the image points (pixelX, pixelY).
inline Vec3Pack pixelDirections(const Camera& camera, FloatPack pixelX, FloatPack pixelY) {
  const float edge = pixelEdge(camera);
  const FloatPack x = (pixelX - 0.5f * camera.width) * edge;
  const FloatPack y = (0.5f * camera.height - pixelY) * edge;
  const Vec3Pack v{camera.forward.x + x * camera.right.x + y * camera.up.x,
                   camera.forward.y + x * camera.right.y + y * camera.up.y,
                   camera.forward.z + x * camera.right.z + y * camera.up.z};
  const FloatPack inverseLength = 1.0f / xsimd::sqrt(dot(v, v));
  return {v.x * inverseLength, v.y * inverseLength, v.z * inverseLength};
}

/// intersectSphere for rays from one origin; `toCenter` leads from there to the sphere's centre.
inline FloatPack intersectSpherePack(const Vec3Pack& direction, const glm::vec3& toCenter, float radius) {
  const float outside = glm::dot(toCenter, toCenter) - radius * radius;
  const FloatPack noHit(kNoHit);
  if (!(outside > 0.0f) || !(radius > 0.0f)) return noHit;
  const FloatPack along = toCenter.x * direction.x + toCenter.y * direction.y + toCenter.z * direction.z;
  const Vec3Pack offset{toCenter.x - along * direction.x, toCenter.y - along * direction.y,
                        toCenter.z - along * direction.z};
  const FloatPack discriminant = radius * radius - dot(offset, offset);
  const FloatPack zero(0.0f);
  const FloatMask hit = (along > zero) & (discriminant >= zero);
  if (!xsimd::any(hit)) return noHit;
  const FloatPack t = outside / (along + xsimd::sqrt(discriminant));
  return xsimd::select(hit, xsimd::select(t > along, along, t), noHit);
}

/// The lanes of a mask as bits, lane 0 lowest.
inline uint32_t laneBits(FloatMask mask) {
  alignas(64) float weights[kPackLanes];
  for (uint32_t i = 0; i < kPackLanes; ++i) weights[i] = static_cast<float>(1u << i);
  // xsimd 8 has no movemask; sums of distinct powers of two are exact.
  return static_cast<uint32_t>(xsimd::hadd(xsimd::select(mask, FloatPack::load_aligned(weights), FloatPack(0.0f))));
}

}  // namespace warpscope
