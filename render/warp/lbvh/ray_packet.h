// pixelRay, intersectSphere and intersectCapsule for as many rays at once as a vector register has lanes. Host only.
// The same operations in the same order as core/camera.h, core/ray_sphere.h and core/ray_capsule.h, so that every lane holds the same bits
// as theirs.
#pragma once

#include <array>
#include <cstdint>
#include <xsimd/xsimd.hpp>

#include "render/core/camera.h"
#include "render/core/floating_point.h"
#include "render/core/numeric.h"
#include "render/core/ray_capsule.h"
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

/// intersectCapsule likewise.
inline FloatPack intersectCapsulePack(const Vec3Pack& direction, const glm::vec3& toCenter, const SeenCapsule& capsule) {
  const FloatPack noHit(kNoHit), zero(0.0f), one(1.0f);
  if (!(capsule.radius > 0.0f)) return noHit;
  const glm::vec3& half = capsule.half;
  const FloatPack squaredRadius(capsule.radius * capsule.radius);
  const auto dotOf = [&](const glm::vec3& v) { return v.x * direction.x + v.y * direction.y + v.z * direction.z; };
  const auto notNegative = [&](const FloatPack& v) { return FloatPack(xsimd::select(v > zero, v, zero)); };
  const auto onLine = [&](const FloatPack& s) {
    const FloatPack behind = xsimd::select(s > -one, s, -one);
    return FloatPack(xsimd::select(behind < one, behind, one));
  };
  const FloatPack along = dotOf(half), center = dotOf(toCenter);
  const Vec3Pack across{half.x - along * direction.x, half.y - along * direction.y, half.z - along * direction.z};
  const Vec3Pack offset{toCenter.x - center * direction.x, toCenter.y - center * direction.y, toCenter.z - center * direction.z};
  const FloatPack breadth = xsimd::sqrt(dot(across, across));
  const FloatMask isBroad = breadth > zero;
  // In lanes whose rays run along the line, numbers are divided by 0.
  return exceptionsExpected([&] {
    const Vec3Pack unit{across.x / breadth, across.y / breadth, across.z / breadth};
    const FloatPack toward = dot(offset, unit);
    const Vec3Pack apart{offset.x - toward * unit.x, offset.y - toward * unit.y, offset.z - toward * unit.z};
    const FloatPack depth = xsimd::sqrt(notNegative(squaredRadius - dot(apart, apart)));
    const FloatPack nearest = xsimd::select(isBroad, onLine(-toward / breadth), zero);
    const FloatPack first = xsimd::select(isBroad, onLine((-toward - depth * along / xsimd::sqrt(along * along + breadth * breadth)) / breadth),
                                          xsimd::select(along > zero, -one, one));
    const Vec3Pack passed{offset.x + nearest * across.x, offset.y + nearest * across.y, offset.z + nearest * across.z};
    const Vec3Pack toFirst{toCenter.x + first * half.x, toCenter.y + first * half.y, toCenter.z + first * half.z};
    const FloatPack toPoint = dot(toFirst, direction), outside = dot(toFirst, toFirst) - squaredRadius;
    const Vec3Pack beside{toFirst.x - toPoint * direction.x, toFirst.y - toPoint * direction.y, toFirst.z - toPoint * direction.z};
    const FloatPack t = outside / (toPoint + xsimd::sqrt(notNegative(squaredRadius - dot(beside, beside))));
    const FloatMask hit = (squaredRadius - dot(passed, passed) >= zero) & (toPoint > zero) & (outside > zero);
    return FloatPack(xsimd::select(hit, FloatPack(xsimd::select(t > toPoint, toPoint, t)), noHit));
  });
}

/// Capsules whose lines are kept by id; what a TileTracer takes them for.
struct CapsuleIntersection {
  const glm::vec3* halfLines = nullptr;
};

/// What a kind of intersection wants to know of the sphere with that id, once for all rays from an origin.
inline SeenSphere preparedFor(StableSphere, uint32_t, const glm::vec3& toCenter, float radius) { return seenSphere(toCenter, radius); }
inline float preparedFor(TextbookSphere, uint32_t, const glm::vec3&, float radius) { return radius; }
inline SeenCapsule preparedFor(const CapsuleIntersection& capsules, uint32_t id, const glm::vec3& toCenter, float radius) {
  return seenCapsule(toCenter, capsules.halfLines[id], radius);
}

inline FloatPack intersectPack(StableSphere, const Vec3Pack& direction, const glm::vec3& toCenter, const SeenSphere& seen) {
  return intersectSpherePack(direction, toCenter, seen);
}
inline FloatPack intersectPack(TextbookSphere, const Vec3Pack& direction, const glm::vec3& toCenter, float radius) {
  return intersectTextbookPack(direction, toCenter, radius);
}

inline FloatPack intersectPack(const CapsuleIntersection&, const Vec3Pack& direction, const glm::vec3& toCenter, const SeenCapsule& capsule) {
  return intersectCapsulePack(direction, toCenter, capsule);
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
