// A tile of pixels walks the hierarchy of lbvh.h together; each sphere that it meets is intersected with the blocks of pixels that it may cover
// and in which it may be the nearest. Host only. Frustum and packet traversal after Wald, Boulos, Shirley 2007 ("Ray Tracing Deformable Scenes
// using Dynamic Bounding Volume Hierarchies"), but with planes through the eye instead of interval arithmetic, and with spheres around nodes,
// as boxes cannot tell large spheres that lie dense from one another; several hits as Gribble, Naveros, Kerzner 2014.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "render/warp/lbvh/bulge.h"
#include "render/warp/lbvh/lbvh.h"
#include "render/warp/lbvh/ray_packet.h"

namespace warpscope {

inline constexpr uint32_t kTileSide = 16;  ///< pixels
static_assert(kTileSide % kPackLanes == 0);
static_assert(kTileSide % 4 == 0);

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
    return nearWithin(first, offset, [&](uint32_t) { return FloatPack(distance); });
  }
  /// Likewise any point of the line from `offset` - `half` to `offset` + `half`.
  uint32_t near(uint32_t first, const glm::vec3& offset, float distance, const glm::vec3& half) const {
    return nearWithin(first, offset, [&](uint32_t i) { return distance + xsimd::abs(signedDistances(i, half)); });
  }

 private:
  FloatPack signedDistances(uint32_t i, const glm::vec3& offset) const {
    return FloatPack::load_unaligned(&x_[i]) * offset.x + FloatPack::load_unaligned(&y_[i]) * offset.y + FloatPack::load_unaligned(&z_[i]) * offset.z;
  }

  template <class DistanceAt>
  uint32_t nearWithin(uint32_t first, const glm::vec3& offset, const DistanceAt& distanceAt) const {
    uint32_t bits = 0;
    for (uint32_t i = 0; i < kTileSide; i += kPackLanes) {
      bits |= laneBits(xsimd::abs(signedDistances(first + i, offset)) <= distanceAt(first + i)) << i;
    }
    return bits;
  }

  std::vector<float> x_, y_, z_;
};

/// What all tiles of a picture share. The view and the camera stay where they are.
struct PacketScene {
  const GroupedLbvhView& view;
  const Camera& camera;
  PlaneFan columns;
  PlaneFan rows;
  float margin;
};

inline PacketScene makePacketScene(const GroupedLbvhView& view, const Camera& camera) {
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
  TileTracer(const PacketScene& scene, int hits, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1, const Intersection& intersection = {})
      : scene_(scene), intersection_(intersection), last_(Capacity == 1 ? 0 : hits - 1), x0_(x0), y0_(y0) {
    const Camera& camera = scene.camera;
    alignas(64) std::array<float, kPackLanes> laneX, laneY;
    for (uint32_t lane = 0; lane < kPackLanes; ++lane) {
      laneX[lane] = static_cast<float>(lane % kGroupWidth);
      laneY[lane] = static_cast<float>(lane / kGroupWidth);
    }
    for (uint32_t i = 0; i < kRays; i += kPackLanes) {
      const uint32_t group = i / kPackLanes;
      const FloatPack column = static_cast<float>(x0 + group % kGroupColumns * kGroupWidth) + FloatPack::load_aligned(laneX.data());
      const FloatPack row = static_cast<float>(y0 + group / kGroupColumns * kGroupHeight) + FloatPack::load_aligned(laneY.data());
      const Vec3Pack direction = pixelDirections(camera, column + 0.5f, row + 0.5f);
      direction.x.store_aligned(&directionX_[i]);
      direction.y.store_aligned(&directionY_[i]);
      direction.z.store_aligned(&directionZ_[i]);
      // Pixels outside the image are hit by nothing and never the farthest.
      const FloatMask inside = (column < FloatPack(static_cast<float>(x1))) & (row < FloatPack(static_cast<float>(y1)));
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
    // The ray of a corner is the farthest from the axis.
    for (const uint32_t x : {x0, x1 - 1})
      for (const uint32_t y : {y0, y1 - 1}) spread_ = std::max(spread_, spreadOf(axis_, directionOf(rayOf(x, y))));
  }

  /// The pixel's ray is to meet nothing. Before trace().
  void leaveOut(uint32_t x, uint32_t y) {
    const uint32_t ray = rayOf(x, y);
    for (int hit = 0; hit <= last_; ++hit) t_[static_cast<size_t>(hit)][ray] = -kNoHit;
    updateGroup(ray / kPackLanes * kPackLanes);
  }

  /// The hierarchy must not be empty.
  void trace() {
    struct Entry {
      uint32_t reference;
      float depth;
    };
    std::array<Entry, kMaxLbvhDepth> stack;
    uint32_t size = 0;
    Entry entry{scene_.view.leafCount() == 1 ? kLbvhLeafBit : 0, 0.0f};
    for (;;) {
      if (entry.reference & kLbvhLeafBit) {
        testSpheres(scene_.view.spheresOf(entry.reference & ~kLbvhLeafBit));
      } else {
        const LbvhNode& node = scene_.view.nodes[entry.reference];
        Entry left{node.child[0], nearestDepth(node, 0)};
        Entry right{node.child[1], nearestDepth(node, 1)};
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
  // A pack holds a block of pixels: of all shapes the one that spheres tell apart best.
  static constexpr uint32_t kGroupWidth = std::min(kPackLanes, 4u);
  static constexpr uint32_t kGroupHeight = kPackLanes / kGroupWidth;
  static constexpr uint32_t kGroupColumns = kTileSide / kGroupWidth;
  static constexpr uint32_t kGroupRows = kTileSide / kGroupHeight;
  static constexpr uint32_t kGroups = kRays / kPackLanes;
  static_assert(kGroups % kPackLanes == 0 && kGroups <= 64);
  /// Where a sphere may cover more groups than this, finding out in which of them it may be the nearest is worth it.
  static constexpr int kFewGroups = 2;
  static constexpr uint32_t kPlanes = 5;
  static constexpr uint32_t kNearPlane = 4;
  static constexpr uint32_t kPaddedPlanes = (kPlanes + kPackLanes - 1) / kPackLanes * kPackLanes;

  uint32_t rayOf(uint32_t x, uint32_t y) const {
    const uint32_t column = x - x0_, row = y - y0_;
    return (row / kGroupHeight * kGroupColumns + column / kGroupWidth) * kPackLanes + row % kGroupHeight * kGroupWidth + column % kGroupWidth;
  }

  glm::vec3 directionOf(uint32_t ray) const { return {directionX_[ray], directionY_[ray], directionZ_[ray]}; }

  /// At most the distance to anything below that child; kNoHit if no ray can meet any of it before what it has met.
  float nearestDepth(const LbvhNode& node, int side) const {
    const Box& box = node.bounds[side];
    const float depth = nearestDepth(box);
    const glm::vec3 halfExtent = 0.5f * (box.upper - box.lower);
    const float largest = std::max({halfExtent.x, halfExtent.y, halfExtent.z});
    // Around a node that is much larger than its spheres, a sphere tells nothing that the box does not.
    if (depth == kNoHit || !(largest < 4.0f * node.smallestRadius[side])) return depth;
    const glm::vec3 toMiddle = 0.5f * (box.lower + box.upper) - scene_.camera.eye;
    const Bulge bulge{glm::length(toMiddle), boundingRadius(halfExtent, node.smallestRadius[side]) + scene_.margin};
    if (!bulge.isTelling()) return depth;
    // As Beams: the tile is one.
    const float offset = glm::length(toMiddle - glm::dot(toMiddle, axis_) * axis_) - bulge.distance * spread_ - scene_.margin;
    if (offset > bulge.radius) return kNoHit;
    const float bulgeNear = bulgeDepth(bulge, std::max(offset, 0.0f)) - scene_.margin;
    return bulgeNear > farthest_ ? kNoHit : std::max(depth, bulgeNear);
  }

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

  void testSpheres(MortonRange range) {
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
    const uint32_t place = scene_.view.ids[i];
    float nearest = std::sqrt(glm::dot(toCenter, toCenter)) - distance;
    uint64_t groups = 0;
    if constexpr (std::is_same_v<Intersection, CapsuleIntersection>) {
      const glm::vec3& half = intersection_.halfLines[place];
      nearest -= glm::length(half);
      if (nearest > farthest_) return false;
      const uint32_t columns = scene_.columns.near(x0_, toCenter, distance, half);
      if (columns == 0) return false;
      groups = groupsAt(columns, scene_.rows.near(y0_, toCenter, distance, half));
    } else {
      if (nearest > farthest_) return false;
      const uint32_t columns = scene_.columns.near(x0_, toCenter, distance);
      if (columns == 0) return false;
      groups = groupsAt(columns, scene_.rows.near(y0_, toCenter, distance));
      if (std::popcount(groups) > kFewGroups) groups &= groupsBehind(toCenter, nearest + distance, sphere.radius);
    }
    const IntPack id(static_cast<int32_t>(place));
    const auto prepared = preparedFor(intersection_, place, toCenter, sphere.radius);
    bool closer = false;
    for (; groups != 0; groups &= groups - 1) {
      const auto group = static_cast<uint32_t>(std::countr_zero(groups));
      if (nearest <= groupFarthest_[group]) closer |= testGroup(group * kPackLanes, toCenter, prepared, id);
    }
    return closer;
  }

  /// The groups that hold pixels of these columns and rows (bits), as bits.
  static uint64_t groupsAt(uint32_t columns, uint32_t rows) {
    uint64_t inRow = 0;
    for (uint32_t column = 0; column < kGroupColumns; ++column)
      inRow |= uint64_t{(columns >> (column * kGroupWidth) & ((1u << kGroupWidth) - 1)) != 0} << column;
    uint64_t groups = 0;
    for (uint32_t row = 0; row < kGroupRows; ++row)
      if (rows >> (row * kGroupHeight) & ((1u << kGroupHeight) - 1)) groups |= inRow << (row * kGroupColumns);
    return groups;
  }

  /// The groups in which a ray may meet the sphere before what it has met, as bits.
  uint64_t groupsBehind(const glm::vec3& toCenter, float distance, float radius) {
    constexpr bool kIsSeenWhole = std::is_same_v<Intersection, TextbookSphere>;
    const Bulge bulge{distance, (kIsSeenWhole ? radius : std::min(radius, 0.5f * distance)) + scene_.margin};  // what is seen of it: seenRadius
    if (!bulge.isTelling()) return ~uint64_t{0};
    if (!hasBeams_) makeBeams();
    return beams_.behind(0, kGroups, toCenter, bulge, scene_.margin, groupFarthest_.data());
  }

  void makeBeams() {
    for (uint32_t group = 0; group < kGroups; ++group) {
      const uint32_t first = group * kPackLanes, last = first + kPackLanes - 1;
      beams_.set(group, {directionOf(first), directionOf(first + kGroupWidth - 1), directionOf(last + 1 - kGroupWidth), directionOf(last)});
    }
    hasBeams_ = true;
  }

  template <class Prepared>
  bool testGroup(uint32_t ray, const glm::vec3& toCenter, const Prepared& sphere, const IntPack& id) {
    const Vec3Pack direction{FloatPack::load_aligned(&directionX_[ray]), FloatPack::load_aligned(&directionY_[ray]),
                             FloatPack::load_aligned(&directionZ_[ray])};
    HitPack hit{intersectPack(intersection_, direction, toCenter, sphere), id};
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
  const Intersection intersection_;
  int last_;  // place of the farthest hit that is kept
  uint32_t x0_;
  uint32_t y0_;
  glm::vec3 axis_;
  float spread_ = 0.0f;      // sine of the largest angle between a ray and the axis
  float farthest_ = kNoHit;  // of all rays' last hits
  bool hasBeams_ = false;
  alignas(64) std::array<float, kPaddedPlanes> planeX_{}, planeY_{}, planeZ_{}, planeEye_{}, limit_{};
  alignas(64) std::array<float, kRays> directionX_, directionY_, directionZ_;
  alignas(64) std::array<std::array<float, kRays>, Capacity> t_;  // nearest hits first
  alignas(64) std::array<std::array<int32_t, kRays>, Capacity> id_;
  alignas(64) std::array<float, kGroups> groupFarthest_;  // of each group's last hits
  Beams<kGroups> beams_;  // once hasBeams_
};

}  // namespace warpscope
