// A tile of pixels walks the hierarchy of lbvh.h together; each sphere that it meets is intersected with the rows and columns that it may
// cover. Host only. Frustum and packet traversal after Wald, Boulos, Shirley 2007 ("Ray Tracing Deformable Scenes using Dynamic Bounding
// Volume Hierarchies"), but with planes through the eye instead of interval arithmetic; several hits as Gribble, Naveros, Kerzner 2014.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "render/warp/lbvh/lbvh.h"
#include "render/warp/lbvh/ray_packet.h"

namespace warpscope {

inline constexpr uint32_t kTileSide = 16;  ///< pixels
static_assert(kTileSide % kPackLanes == 0);
inline constexpr uint32_t kGroupsInRow = kTileSide / kPackLanes;
inline constexpr uint32_t kGroupMask = (1u << (kPackLanes - 1) << 1) - 1;

/// Subtrees of at most this many spheres are not walked but tested one by one.
inline constexpr uint32_t kLeafSpheres = 8;

/// kLbvhMargin covers the exact test and the box test; directions, planes and their products add about as much again.
inline constexpr float kPacketMargin = 2.0f * kLbvhMargin;

/// Unit normals of the planes through the eye and one column (or row) of pixel centres each.
class PlaneFan {
 public:
  /// `across` and the image point's direction span the plane of pixel line i; normals point to the side of `positive`.
  template <class DirectionOf>
  PlaneFan(uint32_t lines, const glm::dvec3& across, const glm::dvec3& positive, const DirectionOf& directionOf) {
    // Lines beyond the image complete the last tile.
    const uint32_t padded = (lines + kTileSide - 1) / kTileSide * kTileSide;
    for (auto* axis : {&x_, &y_, &z_}) axis->resize(padded);
    for (uint32_t i = 0; i < padded; ++i) {
      // In double, so that rounding to float is the planes' only error.
      const glm::dvec3 normal = glm::normalize(glm::cross(across, directionOf(i)));
      const glm::vec3 oriented(glm::dot(normal, positive) < 0.0 ? -normal : normal);
      x_[i] = oriented.x;
      y_[i] = oriented.y;
      z_[i] = oriented.z;
    }
  }

  glm::vec3 normal(uint32_t i) const { return {x_[i], y_[i], z_[i]}; }

  /// Which of the kTileSide planes from `first` on pass `offset` (from the eye) within `distance`, as bits.
  uint32_t near(uint32_t first, const glm::vec3& offset, float distance) const {
    uint32_t bits = 0;
    for (uint32_t i = 0; i < kTileSide; i += kPackLanes) {
      const FloatPack signedDistance = FloatPack::load_unaligned(&x_[first + i]) * offset.x +
                                       FloatPack::load_unaligned(&y_[first + i]) * offset.y +
                                       FloatPack::load_unaligned(&z_[first + i]) * offset.z;
      bits |= laneBits(xsimd::abs(signedDistance) <= FloatPack(distance)) << i;
    }
    return bits;
  }

 private:
  std::vector<float> x_, y_, z_;
};

/// What all tiles of a picture share. The view and the camera stay where they are.
struct PacketScene {
  const LbvhView& view;
  const Camera& camera;
  PlaneFan columns;
  PlaneFan rows;
  float margin;
};

inline PacketScene makePacketScene(const LbvhView& view, const Camera& camera) {
  const glm::dvec3 right(camera.right), up(camera.up), forward(camera.forward);
  const double edge = pixelEdge(camera);
  const glm::vec3 eye = glm::abs(camera.eye);
  return {view, camera,
          PlaneFan(camera.width, up, right,
                   [&](uint32_t i) { return forward + (i + 0.5 - 0.5 * camera.width) * edge * right; }),
          PlaneFan(camera.height, right, -up,
                   [&](uint32_t i) { return forward + (0.5 * camera.height - (i + 0.5)) * edge * up; }),
          kPacketMargin * (eye.x + eye.y + eye.z + view.reach)};
}

/// Finds the first `hits` spheres along each ray, ordered by (distance, id): 1 <= hits <= Capacity.
template <int Capacity, class Intersection = StableSphere>
class TileTracer {
 public:
  TileTracer(const PacketScene& scene, int hits, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)
      : scene_(scene), last_(Capacity == 1 ? 0 : hits - 1), x0_(x0), y0_(y0) {
    const Camera& camera = scene.camera;
    for (uint32_t i = 0; i < kRays; i += kPackLanes) {
      const FloatPack column = static_cast<float>(x0 + i % kTileSide) + laneNumbers();
      const float row = static_cast<float>(y0 + i / kTileSide);
      const Vec3Pack direction = pixelDirections(camera, column + 0.5f, FloatPack(row + 0.5f));
      direction.x.store_aligned(&directionX_[i]);
      direction.y.store_aligned(&directionY_[i]);
      direction.z.store_aligned(&directionZ_[i]);
      // Pixels outside the image are hit by nothing and never the farthest.
      const FloatMask inside = (column < FloatPack(static_cast<float>(x1))) & FloatMask(row < static_cast<float>(y1));
      for (int hit = 0; hit <= last_; ++hit)
        storeHit(hit, i, {xsimd::select(inside, FloatPack(kNoHit), FloatPack(-kNoHit)), IntPack(-1)});
      updateGroup(i);
    }
    // Rays lie between the planes of the first and the last row and column. A box is outside where its farthest corner
    // along a normal lies behind the plane; along -axis that corner is the nearest one.
    axis_ = pixelRay(camera, 0.5f * glm::vec2(x0 + x1, y0 + y1)).direction;
    const std::array<glm::vec3, kPlanes> normals{scene.columns.normal(x0), -scene.columns.normal(x1 - 1),
                                                 scene.rows.normal(y0), -scene.rows.normal(y1 - 1), -axis_};
    for (uint32_t k = 0; k < kPlanes; ++k) {
      planeX_[k] = normals[k].x;
      planeY_[k] = normals[k].y;
      planeZ_[k] = normals[k].z;
      planeEye_[k] = glm::dot(normals[k], camera.eye);
      limit_[k] = -scene.margin;
    }
    limit_[kNearPlane] = -kNoHit;
  }

  /// The hierarchy must not be empty.
  void trace() {
    struct Entry {
      LeafRange range;
      uint32_t reference;
      float depth;
    };
    std::array<Entry, kMaxLbvhDepth> stack;
    uint32_t size = 0;
    Entry entry{{0, scene_.view.count - 1}, 0, 0.0f};
    for (;;) {
      if (entry.range.last - entry.range.first < kLeafSpheres) {
        testSpheres(entry.range);
      } else {
        const LbvhNode& node = scene_.view.nodes[entry.reference];
        const uint32_t split = node.child[0] & ~kLbvhLeafBit;
        Entry left{{node.first, split}, node.child[0], nearestDepth(node.bounds[0])};
        Entry right{{split + 1, node.last}, node.child[1], nearestDepth(node.bounds[1])};
        if (right.depth < left.depth) std::swap(left, right);
        if (right.depth < kNoHit) {
          if (size == stack.size()) throw std::logic_error("the sphere hierarchy is deeper than its keys allow");
          stack[size++] = right;
        }
        if (left.depth < kNoHit) {
          entry = left;
          continue;
        }
      }
      do {
        if (size == 0) return;
        entry = stack[--size];
      } while (entry.depth > farthest_);
    }
  }

  /// Of the pixel (x, y), kNoHit and kNoSample where it has no such hit. 0 <= hit < hits.
  float t(int hit, uint32_t x, uint32_t y) const { return t_[static_cast<size_t>(hit)][rayOf(x, y)]; }
  uint32_t id(int hit, uint32_t x, uint32_t y) const { return static_cast<uint32_t>(id_[static_cast<size_t>(hit)][rayOf(x, y)]); }

 private:
  static constexpr uint32_t kRays = kTileSide * kTileSide;
  static constexpr uint32_t kGroups = kRays / kPackLanes;
  static_assert(kGroups % kPackLanes == 0);
  static constexpr uint32_t kPlanes = 5;
  static constexpr uint32_t kNearPlane = 4;
  static constexpr uint32_t kPaddedPlanes = (kPlanes + kPackLanes - 1) / kPackLanes * kPackLanes;

  uint32_t rayOf(uint32_t x, uint32_t y) const { return (y - y0_) * kTileSide + x - x0_; }

  /// Along the tile's axis, at most the distance to anything in the box; kNoHit if no ray can meet the box before what
  /// it has met.
  float nearestDepth(const Box& box) const {
    alignas(64) std::array<float, kPaddedPlanes> farthestCorner;
    for (uint32_t k = 0; k < kPaddedPlanes; k += kPackLanes) {
      const FloatPack x = FloatPack::load_aligned(&planeX_[k]);
      const FloatPack y = FloatPack::load_aligned(&planeY_[k]);
      const FloatPack z = FloatPack::load_aligned(&planeZ_[k]);
      const FloatPack corner = xsimd::max(x * box.lower.x, x * box.upper.x) +
                               xsimd::max(y * box.lower.y, y * box.upper.y) +
                               xsimd::max(z * box.lower.z, z * box.upper.z) - FloatPack::load_aligned(&planeEye_[k]);
      if (xsimd::any(corner < FloatPack::load_aligned(&limit_[k]))) return kNoHit;
      corner.store_aligned(&farthestCorner[k]);
    }
    return -farthestCorner[kNearPlane] - scene_.margin;
  }

  void testSpheres(LeafRange range) {
    bool closer = false;
    for (uint32_t i = range.first; i <= range.last; ++i) closer |= testSphere(i);
    if (!closer) return;
    FloatPack farthest = FloatPack::load_aligned(&groupFarthest_[0]);
    for (uint32_t i = kPackLanes; i < kGroups; i += kPackLanes)
      farthest = xsimd::max(farthest, FloatPack::load_aligned(&groupFarthest_[i]));
    farthest_ = largestLane(farthest);
    limit_[kNearPlane] = -(farthest_ + scene_.margin);
  }

  /// True if any ray meets the sphere before what it has met.
  bool testSphere(uint32_t i) {
    const Sphere& sphere = scene_.view.spheres[i];
    const glm::vec3 toCenter = sphere.center - scene_.camera.eye;
    const float distance = sphere.radius + scene_.margin;
    const float nearest = std::sqrt(glm::dot(toCenter, toCenter)) - distance;
    if (nearest > farthest_) return false;
    const uint32_t columns = scene_.columns.near(x0_, toCenter, distance);
    if (columns == 0) return false;
    const IntPack id(static_cast<int32_t>(scene_.view.ids[i]));
    bool closer = false;
    for (uint32_t rows = scene_.rows.near(y0_, toCenter, distance); rows != 0; rows &= rows - 1) {
      const uint32_t row = static_cast<uint32_t>(std::countr_zero(rows)) * kTileSide;
      for (uint32_t group = 0; group < kGroupsInRow; ++group)
        if (columns >> (group * kPackLanes) & kGroupMask && nearest <= groupFarthest_[row / kPackLanes + group])
          closer |= testGroup(row + group * kPackLanes, toCenter, sphere.radius, id);
    }
    return closer;
  }

  bool testGroup(uint32_t ray, const glm::vec3& toCenter, float radius, const IntPack& id) {
    const Vec3Pack direction{FloatPack::load_aligned(&directionX_[ray]), FloatPack::load_aligned(&directionY_[ray]),
                             FloatPack::load_aligned(&directionZ_[ray])};
    HitPack hit{intersectPack(Intersection{}, direction, toCenter, radius), id};
    if (!xsimd::any(isNearer(hit, loadHit(last_, ray)))) return false;
    // Whatever the new hit displaces becomes the one to insert.
    for (int i = 0; i <= last_; ++i) {
      const HitPack other = loadHit(i, ray);
      const FloatMask isFirst = isNearer(hit, other);
      storeHit(i, ray, select(isFirst, hit, other));
      hit = select(isFirst, other, hit);
    }
    updateGroup(ray);
    return true;
  }

  void updateGroup(uint32_t ray) { groupFarthest_[ray / kPackLanes] = largestLane(loadHit(last_, ray).t); }

  HitPack loadHit(int hit, uint32_t ray) const {
    const auto i = static_cast<size_t>(hit);
    return {FloatPack::load_aligned(&t_[i][ray]), IntPack::load_aligned(&id_[i][ray])};
  }

  void storeHit(int hit, uint32_t ray, const HitPack& pack) {
    const auto i = static_cast<size_t>(hit);
    pack.t.store_aligned(&t_[i][ray]);
    pack.id.store_aligned(&id_[i][ray]);
  }

  const PacketScene& scene_;
  int last_;  // place of the farthest hit that is kept
  uint32_t x0_;
  uint32_t y0_;
  glm::vec3 axis_;
  float farthest_ = kNoHit;  // of all rays' last hits
  alignas(64) std::array<float, kPaddedPlanes> planeX_{}, planeY_{}, planeZ_{}, planeEye_{}, limit_{};
  alignas(64) std::array<float, kRays> directionX_, directionY_, directionZ_;
  alignas(64) std::array<std::array<float, kRays>, Capacity> t_;  // nearest hits first
  alignas(64) std::array<std::array<int32_t, kRays>, Capacity> id_;
  alignas(64) std::array<float, kGroups> groupFarthest_;  // of each group's last hits
};

}  // namespace warpscope
