// Leaping over what a transfer function hides, without moving any sample: for host and device.
// After Deakin, Knoll 2019 ("Efficient ray casting of volumetric images using distance maps"), on the cells of volume/macrocells.h.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "render/core/counters.h"
#include "render/core/numeric.h"
#include "render/march/lattice.h"

namespace warpscope {

/// Macrocells' distances to what is visible. The memory is another's.
struct EmptyCells {
  const uint8_t* distances = nullptr;  ///< as Macrocells::emptyDistances makes them, or for one way (OctantCells); null: nothing is skipped
  glm::ivec3 dims{0};                  ///< fewer than 2^32 cells: they are of many voxels each where a volume is large
  int edgeBits = 0;                    ///< a cell's edge is 2^edgeBits voxels

  WARPSCOPE_HD int edge() const { return 1 << edgeBits; }
  /// How far the nearest visible cell is.
  WARPSCOPE_HD int distance(const glm::ivec3& cell) const {
    const uint32_t row = static_cast<uint32_t>(cell.z) * static_cast<uint32_t>(dims.y) + static_cast<uint32_t>(cell.y);
    const uint32_t place = row * static_cast<uint32_t>(dims.x) + static_cast<uint32_t>(cell.x);
#if defined(__CUDA_ARCH__)
    return __ldg(distances + place);  // where maps are chosen between, nothing else tells which memory they are in
#else
    return distances[place];
#endif
  }
};

/// Likewise, a map for each of the eight ways that rays may go: the distance to the nearest visible cell of those that lie that way, so that a ray leaps
/// farther and less often. Such a map holds for rays that go its way alone.
struct OctantCells {
  const uint8_t* distances = nullptr;  ///< eight maps one after the other, or null; that of rays towards -x is 1 from that of others, -y 2, -z 4
  glm::ivec3 dims{0};
  int edgeBits = 0;

  /// Those for a ray of that direction.
  WARPSCOPE_HD EmptyCells towards(const glm::vec3& direction) const {
    const size_t count = static_cast<size_t>(dims.x) * static_cast<size_t>(dims.y) * static_cast<size_t>(dims.z);
    const int octant = (direction.x < 0.0f ? 1 : 0) + (direction.y < 0.0f ? 2 : 0) + (direction.z < 0.0f ? 4 : 0);
    return {distances + static_cast<size_t>(octant) * count, dims, edgeBits};
  }
};

/// How far beyond a sample's place leap() may see the border that the sample has not reached, relative to the far end
/// of the ray and a step: such samples are looked at for themselves. With u = 2^-24, and all in the ray's own
/// distances:
///  - where the ray leaves the block: the difference, the reciprocal and their product are rounded, relative to where
///    that is, at most t0 + length + dt: 3u;
///  - as an index: the difference from t0, the reciprocal of dt, what both make with the half and the margin are rounded,
///    relative to length + dt: 5u at most;
///  - where the sample is: kLatticeError of t0 + length, 3u.
/// Places in cells add nothing, though they are rounded too: rounding never carries a place across a whole number, and
/// a place on the border itself belongs to the cells on both sides of it (Macrocells). Nor do maps for one way (OctantCells): rounded places go that way too,
/// or stay.
inline constexpr float kLeapMargin = 12 * 0x1p-24f;

/// One ray's way through the cells.
class EmptySpace {
 public:
  WARPSCOPE_HD EmptySpace() = default;
  /// `origin` and `direction`: the ray in voxel coordinates.
  WARPSCOPE_HD EmptySpace(const EmptyCells& cells, const glm::vec3& origin, const glm::vec3& direction,
                          const RayLattice& lattice)
      : cells_(cells),
        origin_(origin / static_cast<float>(cells.edge())),
        direction_(direction / static_cast<float>(cells.edge())),
        invDirection_(1.0f / (direction_ + 0.0f)),
        invStep_(1.0f / lattice.dt),
        margin_(0.5f + kLeapMargin * ((lattice.t0 + lattice.length) / lattice.dt + 1.0f)) {
    for (int axis = 0; axis < 3; ++axis) {
      sign_[axis] = direction_[axis] < 0.0f ? -1 : 1;
      ahead_[axis] = direction_[axis] < 0.0f ? 1 : 0;
    }
  }

  WARPSCOPE_HD bool isKnown() const { return cells_.distances != nullptr; }

  /// The first sample of `lattice` from `i` on that may be visible; its count if there is none.
  WARPSCOPE_HD int skip(int i, const RayLattice& lattice) const {
    if (!isKnown()) return i;
    while (i < lattice.count) {
      const glm::ivec3 cell = cellAt(lattice.t(i));
      const int distance = cells_.distance(cell);
      if (distance == 0) return i;
      i = leap(i, cell, distance, lattice);
    }
    return i;
  }

  /// The same by one leap at most: the sample that it comes to may be as invisible as those before it.
  WARPSCOPE_HD int leapFrom(int i, const RayLattice& lattice) const {
    if (!isKnown() || i >= lattice.count) return i;
    const glm::ivec3 cell = cellAt(lattice.t(i));
    const int distance = cells_.distance(cell);
    return distance == 0 ? i : leap(i, cell, distance, lattice);
  }

  /// The cell of a place on the ray.
  WARPSCOPE_HD glm::ivec3 cellAt(float t) const {
    glm::ivec3 cell;
    for (int axis = 0; axis < 3; ++axis) {
      const float place = mulAdd(t, direction_[axis], origin_[axis]);  // the very place that is sampled: edges are powers of two
      cell[axis] = minOf(truncated(maxOf(place, 0.0f)), cells_.dims[axis] - 1);
    }
    return cell;
  }

  /// The first sample beyond the i-th that may be visible, or the lattice's count, where the i-th lies in `cell` at a distance > 0.
  WARPSCOPE_HD int leap(int i, const glm::ivec3& cell, int distance, const RayLattice& lattice) const {
    // Everything less than `distance` cells away is empty: go on where the ray leaves that block. What lies within rounding of the
    // block's border is looked at for itself.
    WARPSCOPE_COUNT(leaps, 1);
    float exit = lattice.t0 + lattice.length + lattice.dt;
    for (int axis = 0; axis < 3; ++axis) {
      const int bound = cell[axis] + ahead_[axis] + sign_[axis] * distance;
      const float leaves = (converted(bound) - origin_[axis]) * invDirection_[axis];
      exit = minOf(leaves, exit);  // `exit` if the first is NaN: parallel to this side
    }
    return maxOf(i + 1, ceiledTo(mulAdd(exit - lattice.t0, invStep_, -margin_), lattice.count));
  }

  /// As cells.distance() and leap(), of the sample between the voxel `index` and its upper neighbours.
  WARPSCOPE_HD int leapFromVoxel(int i, const int (&index)[3], const RayLattice& lattice) const {
    const glm::ivec3 cell(index[0] >> cells_.edgeBits, index[1] >> cells_.edgeBits, index[2] >> cells_.edgeBits);
    const int distance = cells_.distance(cell);
    return distance == 0 ? i : leap(i, cell, distance, lattice);
  }

 private:
  EmptyCells cells_;
  glm::vec3 origin_{0.0f};  // in cells
  glm::vec3 direction_{0.0f};
  glm::vec3 invDirection_{0.0f};
  float invStep_ = 1.0f;
  float margin_ = 0.5f;      // in steps: samples lie in the middle of theirs, and kLeapMargin
  glm::ivec3 sign_{1}, ahead_{0};  // the way that the ray goes along each axis, and 1 where it leaves blocks by their lower side
};

}  // namespace warpscope
