// Where a sphere is hit at the earliest by rays that pass its middle at some distance: the farther from it, the deeper. Large spheres that lie
// dense are told apart by this, where boxes around them, and their nearest points, all lie at the same depth. Host only.
// Closed form of a ray and a sphere, as a bound for bundles of rays; bundles as cones, cf. Amanatides 1984 ("Ray Tracing with Cones").
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "render/core/simd.h"
#include "render/warp/lbvh/lbvh.h"
#include "render/warp/lbvh/ray_packet.h"

namespace warpscope {

/// kLbvhMargin covers the exact test and the box test; directions, planes and their products add about as much again.
inline constexpr float kPacketMargin = 2.0f * kLbvhMargin;

/// Spheres with smaller radii are not told from others by where they bulge: squares of what is much smaller underflow.
inline constexpr float kSmallestBulge = 0x1p-40f;

/// A sphere around all that is looked at, as seen from the eye.
struct Bulge {
  float distance;  ///< of the centre from the eye
  float radius;    ///< below the distance

  /// False where nothing follows from it: the eye is inside, or squares underflow.
  bool isTelling() const { return radius < distance && radius > kSmallestBulge; }
};

/// At most the distance to the sphere along a ray that passes the centre at `offset` >= 0 or farther. Where a ray passes the middle of a sphere at
/// some distance, the sphere's surface lies that much deeper: sqrt(D^2 - offset^2) - sqrt(R^2 - offset^2), which grows with the offset. For
/// numbers and packs.
template <class Real>
inline Real bulgeDepth(const Bulge& bulge, const Real& offset) {
  const Real zero(0.0f);
  const Real squaredOffset = offset * offset;
  return sqrtOf(maxOf(Real(bulge.distance * bulge.distance) - squaredOffset, zero)) -
         sqrtOf(maxOf(Real(bulge.radius * bulge.radius) - squaredOffset, zero));
}

/// The sine of the angle between two unit vectors, as large as it may be; more than any where the angle is no acute one, as in tiles of pictures that
/// see half of the world: nothing follows then.
inline float spreadOf(const glm::vec3& axis, const glm::vec3& direction) {
  const float cosine = glm::dot(axis, direction);
  return cosine > kPacketMargin ? glm::length(direction - cosine * axis) + kPacketMargin : 2.0f;
}

/// Of blocks of pixels the rays through their middles, and how far their rays are from those. A ray at an angle b to such an axis passes a point by
/// that much nearer than the axis does: sin(a - b) >= sin(a) - sin(b) for a >= b.
template <uint32_t kBlocks>
class Beams {
  static_assert(kBlocks % kPackLanes == 0);

 public:
  /// The directions of a block's four corners, the first and the last opposite each other.
  void set(uint32_t block, const std::array<glm::vec3, 4>& corners) {
    const glm::vec3 axis = glm::normalize(corners.front() + corners.back());
    x_[block] = axis.x;
    y_[block] = axis.y;
    z_[block] = axis.z;
    spread_[block] = 0.0f;
    for (const glm::vec3& corner : corners) spread_[block] = std::max(spread_[block], spreadOf(axis, corner));
  }

  /// Of the `count` blocks from `first` on (multiples of kPackLanes, at most 64), in which a ray may meet the sphere no farther than `farthest` of the
  /// block, as bits. `toCenter` leads from the eye to its centre; `margin` is what all of this may be off by.
  uint64_t behind(uint32_t first, uint32_t count, const glm::vec3& toCenter, const Bulge& bulge, float margin, const float* farthest) const {
    uint64_t bits = 0;
    for (uint32_t i = 0; i < count; i += kPackLanes) {
      const uint32_t block = first + i;
      const Vec3Pack axis{FloatPack::load_aligned(&x_[block]), FloatPack::load_aligned(&y_[block]), FloatPack::load_aligned(&z_[block])};
      const FloatPack along = axis.x * toCenter.x + axis.y * toCenter.y + axis.z * toCenter.z;
      const Vec3Pack beside{toCenter.x - along * axis.x, toCenter.y - along * axis.y, toCenter.z - along * axis.z};
      const FloatPack passed = xsimd::sqrt(dot(beside, beside)) - bulge.distance * FloatPack::load_aligned(&spread_[block]) - margin;
      const FloatPack nearest = bulgeDepth(bulge, xsimd::max(passed, FloatPack(0.0f))) - margin;
      const FloatMask may = (passed <= FloatPack(bulge.radius)) & (nearest <= FloatPack::load_aligned(&farthest[block]));
      bits |= uint64_t{laneBits(may)} << i;
    }
    return bits;
  }

 private:
  alignas(64) std::array<float, kBlocks> x_, y_, z_, spread_;
};

}  // namespace warpscope
