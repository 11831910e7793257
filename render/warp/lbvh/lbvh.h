// A linear bounding volume hierarchy over spheres: layout, construction rules and per-ray traversal, for host and
// device. After Karras, "Maximizing Parallelism in the Construction of BVHs, Octrees, and k-d Trees", HPG 2012, with
// 63-bit codes, equal codes told apart by index (his section 4), and both children's boxes and smallest radii kept in
// the parent.
#pragma once

#include "render/core/host_device.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "render/core/box.h"
#include "render/core/morton.h"
#include "render/core/ray_capsule.h"
#include "render/core/textbook_sphere.h"
#include "render/core/sample.h"

namespace warpscope {

/// The most spheres that a hierarchy can hold: references spend one bit on telling leaves from inner nodes.
inline constexpr uint32_t kMaxLbvhSpheres = 0x7fffffffu;

/// Set in a reference to a leaf; the other bits are the leaf's place in Morton order. Without it they are a node's
/// index. A leaf is one sphere, or a few: see LbvhView and GroupedLbvhView.
inline constexpr uint32_t kLbvhLeafBit = 0x80000000u;

/// Along a path the common prefix of a node's leaves grows with every node: it takes at most the 63 lengths of a code
/// that begins with a zero bit and, among equal codes, the 31 of an index below 2^31. So no path has more inner nodes
/// than this.
inline constexpr uint32_t kMaxLbvhDepth = 63 + 31;

/// An inner node. Node 0 is the root and a hierarchy of n >= 2 leaves has n - 1 nodes. As in the paper, where a node's
/// leaves [first, last] are split after `s`, the left child is node or leaf s and the right one node or leaf s + 1.
struct LbvhNode {
  Box bounds[2];      ///< of the left and the right child, rounded to nearest: queries widen them, see kLbvhMargin
  float smallestRadius[2];  ///< of the spheres below the left and the right child
  uint32_t child[2];  ///< references
};
static_assert(sizeof(LbvhNode) == 64, "one cache line");

/// A run of leaves or spheres in Morton order: first..last, both inclusive.
struct MortonRange {
  uint32_t first;
  uint32_t last;
  bool operator==(const MortonRange&) const = default;
};

/// A hierarchy as traversal sees it, with one sphere a leaf. The memory is another's, on whichever side the traversal runs.
struct LbvhView {
  const LbvhNode* nodes = nullptr;  ///< one less than leaves
  const Sphere* spheres = nullptr;  ///< count, in Morton order
  const uint32_t* ids = nullptr;    ///< count: each sphere's place in the cloud that was built
  uint32_t count = 0;
  float reach = 0.0f;  ///< at least the distance of any point of any sphere from the coordinates' origin
  /// Of capsules (ray_capsule.h) the halves of their lines, by place in the cloud; the spheres are those of their middles. Null where all are spheres.
  const glm::vec3* halfLines = nullptr;

  WARPSCOPE_HD uint32_t leafCount() const { return count; }
  WARPSCOPE_HD MortonRange spheresOf(uint32_t leaf) const { return {leaf, leaf}; }
};

/// As LbvhView, but each largest subtree of at most so many spheres as its builder chose is one leaf: nodes, by far the largest part of a
/// hierarchy, are a quarter to an eighth as many.
struct GroupedLbvhView : LbvhView {
  const uint32_t* leafFirst = nullptr;  ///< leaves + 1: the place of each leaf's first sphere, then count
  uint32_t leaves = 0;

  WARPSCOPE_HD uint32_t leafCount() const { return leaves; }
  WARPSCOPE_HD MortonRange spheresOf(uint32_t leaf) const { return {leafFirst[leaf], leafFirst[leaf + 1] - 1}; }
};

// --- Construction

/// Bounds of a sphere, rounded to nearest.
WARPSCOPE_HD inline Box sphereBounds(const Sphere& sphere) {
  return {sphere.center - sphere.radius, sphere.center + sphere.radius};
}

/// Of that sphere drawn out to both sides.
WARPSCOPE_HD inline Box capsuleBounds(const Sphere& sphere, const glm::vec3& half) {
  const glm::vec3 reach = glm::abs(half) + sphere.radius;
  return {sphere.center - reach, sphere.center + reach};
}

/// LbvhView::reach for spheres within `bounds`: the sum of the largest coordinates bounds their length.
WARPSCOPE_HD inline float reachOf(const Box& bounds) {
  const glm::vec3 farthest = glm::max(glm::abs(bounds.lower), glm::abs(bounds.upper));
  return farthest.x + farthest.y + farthest.z;
}

/// Morton code of `center` within the bounds of all centres. The cells are cubes, as many along the longest axis as the
/// code allows, so that a flat cloud is cut along its plane only; a cloud without any extent has one cell.
WARPSCOPE_HD inline uint64_t mortonCodeOf(const glm::vec3& center, const Box& centerBounds) {
  // Halved before subtracting: the extent of finite bounds stays finite.
  const glm::vec3 halfExtent = 0.5f * centerBounds.upper - 0.5f * centerBounds.lower;
  const float largest = glm::max(halfExtent.x, glm::max(halfExtent.y, halfExtent.z));
  if (!(largest > 0.0f)) return 0;
  constexpr float cells = 2097152.0f;  // 2^21
  const glm::vec3 cell = glm::min((0.5f * center - 0.5f * centerBounds.lower) / largest * cells, cells - 1.0f);
  return mortonCode(static_cast<uint32_t>(cell.x), static_cast<uint32_t>(cell.y), static_cast<uint32_t>(cell.z));
}

WARPSCOPE_HD inline int leadingZeros(uint64_t bits) {
#if defined(__CUDA_ARCH__)
  return __clzll(static_cast<long long>(bits));
#else
  return std::countl_zero(bits);
#endif
}

/// Length of the prefix that the keys of leaves i and j share: the sorted codes, each followed by its index. -1 if
/// there is no leaf j. (Karras 2012, section 3: delta.)
WARPSCOPE_HD inline int commonPrefix(const uint64_t* codes, int64_t count, int64_t i, int64_t j) {
  if (j < 0 || j >= count) return -1;
  const uint64_t difference = codes[i] ^ codes[j];
  if (difference != 0) return leadingZeros(difference);
  return 64 + leadingZeros(static_cast<uint64_t>(i ^ j)) - 32;
}

/// The leaves below inner node i (Karras 2012, figure 4, first half).
WARPSCOPE_HD inline MortonRange determineRange(const uint64_t* codes, uint32_t count, uint32_t node) {
  const int64_t i = node;
  // The range extends to the side of the neighbour that shares more.
  const int64_t direction = commonPrefix(codes, count, i, i + 1) > commonPrefix(codes, count, i, i - 1) ? 1 : -1;
  const int siblingPrefix = commonPrefix(codes, count, i, i - direction);
  int64_t limit = 2;
  while (commonPrefix(codes, count, i, i + limit * direction) > siblingPrefix) limit *= 2;
  int64_t length = 0;
  for (int64_t step = limit / 2; step >= 1; step /= 2)
    if (commonPrefix(codes, count, i, i + (length + step) * direction) > siblingPrefix) length += step;
  const auto other = static_cast<uint32_t>(i + length * direction);
  return direction > 0 ? MortonRange{node, other} : MortonRange{other, node};
}

/// The last leaf of the left child of the node over first < last (Karras 2012, figure 4, second half).
WARPSCOPE_HD inline uint32_t findSplit(const uint64_t* codes, uint32_t count, MortonRange range) {
  const int nodePrefix = commonPrefix(codes, count, range.first, range.last);
  uint32_t split = range.first;
  uint32_t step = range.last - range.first;
  do {
    step = step / 2 + step % 2;
    if (split + step < range.last && commonPrefix(codes, count, range.first, split + step) > nodePrefix) split += step;
  } while (step > 1);
  return split;
}

WARPSCOPE_HD inline uint32_t leftReference(MortonRange range, uint32_t split) {
  return split == range.first ? split | kLbvhLeafBit : split;
}

WARPSCOPE_HD inline uint32_t rightReference(MortonRange range, uint32_t split) {
  return split + 1 == range.last ? (split + 1) | kLbvhLeafBit : split + 1;
}

/// Radius of a sphere around the middle of a box with these half extents that holds all spheres within the box whose
/// radii are at least `smallestRadius`. The farthest point of a sphere in the box's corner is |halfExtent - r| + r away,
/// and the smaller r, the farther. Much smaller than the box where spheres are much larger than their distances.
WARPSCOPE_HD inline float boundingRadius(const glm::vec3& halfExtent, float smallestRadius) {
  return glm::length(glm::max(halfExtent - smallestRadius, glm::vec3(0.0f))) + smallestRadius;
}

// --- Traversal

/// How much wider than its numbers a box is taken, relative to the distances of eye and spheres from the coordinates'
/// origin. A ray that intersectSphere lets hit may in truth pass up to about 3u * (distance + radius) beside the sphere
/// (u = 2^-24), bounds are rounded (u * reach), so is the shifted origin, and the slabs' distances carry 3u each. 16u
/// covers the sum.
inline constexpr float kLbvhMargin = 16.0f / 16777216.0f;

/// What the box test needs of a ray, computed once.
struct LbvhRay {
  glm::vec3 lowerOrigin;  ///< the origin moved up: boxes are widened by moving the ray's origin the other way
  glm::vec3 upperOrigin;
  glm::vec3 invDirection;  ///< finite
};

WARPSCOPE_HD inline LbvhRay lbvhRayOf(const Ray& ray, float reach) {
  const glm::vec3 size = glm::abs(ray.origin);
  const float margin = kLbvhMargin * (size.x + size.y + size.z + reach);
  LbvhRay query{ray.origin + margin, ray.origin - margin, {}};
  for (int axis = 0; axis < 3; ++axis) {
    // Replacing tiny components moves no hit by more than the margin and keeps 0 * infinity out of the slab test.
    constexpr float tiny = 1e-18f;
    const float component = ray.direction[axis];
    query.invDirection[axis] = 1.0f / (std::fabs(component) > tiny ? component : std::copysign(tiny, component));
  }
  return query;
}

/// Distance to where the ray enters the widened box, 0 if it starts inside; negative if it misses it within [0, tMax]. The box is not
/// empty.
WARPSCOPE_HD inline float entryDistance(const LbvhRay& ray, const Box& box, float tMax) {
  const glm::vec3 a = (box.lower - ray.lowerOrigin) * ray.invDirection;
  const glm::vec3 b = (box.upper - ray.upperOrigin) * ray.invDirection;
  const glm::vec3 low = glm::min(a, b);
  const glm::vec3 high = glm::max(a, b);
  const float tNear = glm::max(glm::max(low.x, low.y), glm::max(low.z, 0.0f));
  const float tFar = glm::min(glm::min(high.x, high.y), glm::min(high.z, tMax));
  return tNear <= tFar ? tNear : -1.0f;
}

/// Calls visit(i) for every sphere (i: its place in Morton order) whose leaf `ray` may meet within [0, tMax], nearer
/// subtrees first. `View` is one of the two above. `visit` may lower tMax, which is looked at again before each node. Returns false if the stack
/// overflowed: the result is then incomplete and must not be used. That cannot happen with nodes built by the rules
/// above.
template <class View, class Visit>
WARPSCOPE_HD inline bool visitAlongRay(const View& view, const Ray& ray, const float& tMax, Visit&& visit) {
  if (view.count == 0) return true;
  const LbvhRay query = lbvhRayOf(ray, view.reach);
  uint32_t stack[kMaxLbvhDepth];
  float stackEntry[kMaxLbvhDepth];
  uint32_t size = 0;
  uint32_t reference = view.leafCount() == 1 ? kLbvhLeafBit : 0;
  for (;;) {
    if (reference & kLbvhLeafBit) {
      const MortonRange leaf = view.spheresOf(reference & ~kLbvhLeafBit);
      for (uint32_t i = leaf.first; i <= leaf.last; ++i) visit(i);
    } else {
      const LbvhNode& node = view.nodes[reference];
      const float left = entryDistance(query, node.bounds[0], tMax);
      const float right = entryDistance(query, node.bounds[1], tMax);
      if (left >= 0.0f && right >= 0.0f) {
        if (size == kMaxLbvhDepth) return false;
        const uint32_t near = right < left ? 1 : 0;
        stack[size] = node.child[1 - near];
        stackEntry[size++] = near == 1 ? left : right;
        reference = node.child[near];
        continue;
      }
      if (left >= 0.0f || right >= 0.0f) {
        reference = node.child[left >= 0.0f ? 0 : 1];
        continue;
      }
    }
    do {
      if (size == 0) return true;
      reference = stack[--size];
    } while (stackEntry[size] > tMax);
  }
}

struct LbvhHit {
  float t = kNoHit;         ///< distance along the ray
  uint32_t id = kNoSample;  ///< place in the cloud that was built
  bool overflow = false;    ///< the traversal gave up: the caller must fail
};

/// What closestHit() takes for capsules.
struct StableCapsule {};

/// Distance along `ray` to the sphere, or capsule, at that place in Morton order.
template <class Intersection, class View>
WARPSCOPE_HD inline float distanceTo(const View& view, const Ray& ray, uint32_t i) {
  const Sphere& sphere = view.spheres[i];
  if constexpr (std::is_same_v<Intersection, StableCapsule>)
    return intersectCapsule(ray, sphere.center, view.halfLines[view.ids[i]], sphere.radius);
  else
    return Intersection::intersect(ray, sphere.center, sphere.radius);
}

/// The first sphere along `ray` (unit direction); of equally near ones that with the lowest id. See intersectSphere for
/// what is a hit.
template <class Intersection = StableSphere, class View>
WARPSCOPE_HD inline LbvhHit closestHit(const View& view, const Ray& ray) {
  LbvhHit hit;
  hit.overflow = !visitAlongRay(view, ray, hit.t, [&](uint32_t i) {
    const float t = distanceTo<Intersection>(view, ray, i);
    if (t < hit.t || (t == hit.t && t < kNoHit && view.ids[i] < hit.id)) {
      hit.t = t;
      hit.id = view.ids[i];
    }
  });
  return hit;
}

}  // namespace warpscope
