// pixelRay and intersectSphere for as many rays at once as a vector register has lanes. Host only.
// The same operations in the same order as core/camera.h and core/ray_sphere.h, so that every lane holds the same bits
// as theirs.
#pragma once

#include <array>
#include <cstdint>
#include <xsimd/xsimd.hpp>

#include "render/core/camera.h"
#include "render/core/floating_point.h"
#include "render/core/numeric.h"
#include "render/core/textbook_sphere.h"

namespace warpscope {

using FloatPack = xsimd::batch<float>;
using IntPack = xsimd::batch<int32_t>;
using FloatMask = xsimd::batch_bool<float>;
inline constexpr uint32_t kPackLanes = FloatPack::size;
static_assert(IntPack::size == kPackLanes);

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
  const FloatPack x = (pixelX - 0.5f * static_cast<float>(camera.width)) * edge;
  const FloatPack y = (0.5f * static_cast<float>(camera.height) - pixelY) * edge;
  const Vec3Pack v{camera.forward.x + x * camera.right.x + y * camera.up.x,
                   camera.forward.y + x * camera.right.y + y * camera.up.y,
                   camera.forward.z + x * camera.right.z + y * camera.up.z};
  const FloatPack inverseLength = 1.0f / xsimd::sqrt(dot(v, v));
  return {v.x * inverseLength, v.y * inverseLength, v.z * inverseLength};
}

/// intersectSphere for rays from one origin; `toCenter` leads from there to the sphere's centre, `seen` is what it seems.
inline FloatPack intersectSpherePack(const Vec3Pack& direction, const glm::vec3& toCenter, const SeenSphere& seen) {
  const auto [radius, outside] = seen;
  const FloatPack noHit(kNoHit);
  if (!(outside > 0.0f) || !(radius > 0.0f)) return noHit;
  const FloatPack along = toCenter.x * direction.x + toCenter.y * direction.y + toCenter.z * direction.z;
  const Vec3Pack offset{toCenter.x - along * direction.x, toCenter.y - along * direction.y,
                        toCenter.z - along * direction.z};
  const FloatPack discriminant = radius * radius - dot(offset, offset);
  const FloatPack zero(0.0f);
  // Where every lane misses, leaving early would cost more in mispredicted branches than it saves.
  const FloatMask hit = (along > zero) & (discriminant >= zero);
  // In lanes that miss, roots of negative numbers, and what is divided by them.
  const FloatPack t = exceptionsExpected([&, outside = outside] { return outside / (along + xsimd::sqrt(discriminant)); });
  return xsimd::select(hit, exceptionsExpected([&] { return xsimd::select(t > along, along, t); }), noHit);
}

/// intersectSphereTextbook likewise.
inline FloatPack intersectTextbookPack(const Vec3Pack& direction, const glm::vec3& toCenter, float radius) {
  const FloatPack a = dot(direction, direction);
  const FloatPack b = -2.0f * (toCenter.x * direction.x + toCenter.y * direction.y + toCenter.z * direction.z);
  const FloatPack c(glm::dot(toCenter, toCenter) - radius * radius);
  const FloatPack discriminant = b * b - 4.0f * a * c;
  const FloatPack zero(0.0f), noHit(kNoHit);
  const FloatPack t = (-b - xsimd::sqrt(xsimd::max(discriminant, zero))) / (2.0f * a);
  return xsimd::select((discriminant >= zero) & (t > zero), t, noHit);
}

inline FloatPack intersectSpherePack(const Vec3Pack& direction, const glm::vec3& toCenter, float radius) {
  return intersectSpherePack(direction, toCenter, seenSphere(toCenter, radius));
}

/// What an arithmetic wants to know of a sphere, once for all rays from an origin.
inline SeenSphere preparedFor(StableSphere, const glm::vec3& toCenter, float radius) { return seenSphere(toCenter, radius); }
inline float preparedFor(TextbookSphere, const glm::vec3&, float radius) { return radius; }

inline FloatPack intersectPack(StableSphere, const Vec3Pack& direction, const glm::vec3& toCenter, const SeenSphere& seen) {
  return intersectSpherePack(direction, toCenter, seen);
}
inline FloatPack intersectPack(TextbookSphere, const Vec3Pack& direction, const glm::vec3& toCenter, float radius) {
  return intersectTextbookPack(direction, toCenter, radius);
}

/// What each ray has met: a distance, kNoHit where it has met nothing, and an id below 2^31, -1 where there is none.
struct HitPack {
  FloatPack t;
  IntPack id;
};

/// Which lanes of `hit` come before those of `best`: nearer, or as near and of a lower id.
inline FloatMask isNearer(const HitPack& hit, const HitPack& best) {
  // Ids are below 2^31, so that signed comparison orders them; -1 wins no tie because its distance is infinite.
  const FloatMask tie = (hit.t == best.t) & (hit.t < FloatPack(kNoHit)) & xsimd::bool_cast(hit.id < best.id);
  return (hit.t < best.t) | tie;
}

inline HitPack select(const FloatMask& mask, const HitPack& a, const HitPack& b) {
  return {xsimd::select(mask, a.t, b.t), xsimd::select(xsimd::bool_cast(mask), a.id, b.id)};
}

inline float largestLane(const FloatPack& pack) {
  alignas(64) std::array<float, kPackLanes> lanes;
  pack.store_aligned(lanes.data());
  // Halves against each other: few steps that depend on one another.
  for (uint32_t half = kPackLanes / 2; half > 0; half /= 2)
    for (uint32_t i = 0; i < half; ++i) lanes[i] = maxOf(lanes[i], lanes[i + half]);
  return lanes[0];
}

/// The lanes of a mask as bits, lane 0 lowest.
inline uint32_t laneBits(const FloatMask& mask) {
  // xsimd 8 has no function for what most processors do in one instruction.
#if defined(__AVX512F__)
  return mask.data;
#elif defined(__AVX__)
  return static_cast<uint32_t>(_mm256_movemask_ps(mask.data));
#elif defined(__SSE2__)
  return static_cast<uint32_t>(_mm_movemask_ps(mask.data));
#else
  alignas(64) float weights[kPackLanes];
  for (uint32_t i = 0; i < kPackLanes; ++i) weights[i] = static_cast<float>(1u << i);
  // Sums of distinct powers of two are exact.
  return static_cast<uint32_t>(xsimd::hadd(xsimd::select(mask, FloatPack::load_aligned(weights), FloatPack(0.0f))));
#endif
}

}  // namespace warpscope
