// Builds the hierarchy of lbvh.h on all cores of the host.
// After Karras 2012, section 4; codes are sorted by a least-significant-digit radix sort (Knuth, TAOCP 3,
// section 5.2.5), and as boxes need a walk over the tree anyway, that walk finds the ranges too instead of one thread a
// node. Small subtrees are leaves, which saves most of the nodes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/warp/lbvh/lbvh.h"

namespace warpscope {

/// Largest coordinate and radius of a sphere: squares of distances stay clear of overflow.
inline constexpr float kMaxSphereCoordinate = 1e18f;

/// Throws InputError if there are more than kMaxLbvhSpheres, or naming the first sphere whose coordinates are not
/// finite and within kMaxSphereCoordinate or whose radius is not positive and within it.
void validateSpheres(std::span<const Sphere> spheres);

/// A Morton code and where it came from.
struct MortonItem {
  uint64_t code;
  uint32_t index;
};

/// Sorts by code; equal codes keep their order. `scratch` is resized as needed. The result does not depend on the
/// number of threads.
void sortByCode(std::vector<MortonItem>& items, std::vector<MortonItem>& scratch);

/// Subtrees of at most this many spheres are leaves: packets of rays test them one by one.
inline constexpr uint32_t kLeafSpheres = 8;

/// A hierarchy that owns its memory, and keeps it from one build to the next, unless that would be gigabytes.
class Lbvh {
 public:
  /// Replaces what was there. The result depends on the spheres and their order only, not on the number of threads.
  /// Throws as validateSpheres does; the hierarchy is then empty. `halfLines`, unless empty, makes the spheres capsules: one finite vector for each, see LbvhView.
  void build(std::span<const Sphere> spheres, std::span<const glm::vec3> halfLines = {});

  /// Valid until the next build.
  GroupedLbvhView view() const;

  /// Of each leaf's first sphere, in sorted order, as construction used them.
  std::span<const uint64_t> codes() const { return codes_; }

 private:
  /// Of the spheres below a node.
  struct Extent {
    Box bounds;
    float smallestRadius;
  };
  void findLeaves();
  void markLeaves(MortonRange spheres);
  Extent emitNode(uint32_t node, MortonRange leaves);
  Extent emitChild(uint32_t reference, MortonRange leaves);
  Extent extentOf(uint32_t leaf) const;
  Box boundsOf(uint32_t i) const;

  std::vector<LbvhNode> nodes_;
  std::vector<uint32_t> leafFirst_;
  std::vector<Sphere> spheres_;
  std::vector<uint32_t> ids_;
  std::vector<glm::vec3> halfLines_;  // by id; empty where all are spheres
  std::vector<uint64_t> codes_;  // of all spheres until the leaves are known
  std::vector<uint8_t> isLeafFirst_;
  float reach_ = 0.0f;
  std::vector<MortonItem> items_;
  std::vector<MortonItem> scratch_;
};

}  // namespace warpscope
