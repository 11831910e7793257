// Leaping over what a transfer function hides, without moving any sample: for host and device.
// After Deakin, Knoll 2019 ("Efficient ray casting of volumetric images using distance maps"), on the cells of volume/macrocells.h.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "render/core/numeric.h"
#include "render/march/lattice.h"

namespace warpscope {

/// Macrocells' distances to what is visible. The memory is another's.
struct EmptyCells {
  const uint8_t* distances = nullptr;  ///< as Macrocells::emptyDistances makes them, or null: nothing is skipped
  glm::ivec3 dims{0};
  int edge = 1;  ///< voxels along a cell's edge
};

/// One ray's way through the cells.
class EmptySpace {
 public:
  WARPSCOPE_HD EmptySpace() = default;
  /// `origin` and `direction`: the ray in voxel coordinates, of a volume with `dims` voxels.
  WARPSCOPE_HD EmptySpace(const EmptyCells& cells, const glm::vec3& origin, const glm::vec3& direction, const glm::ivec3& dims,
                          const RayLattice& lattice)
      : cells_(cells),
        origin_(origin / static_cast<float>(cells.edge)),
        direction_(direction / static_cast<float>(cells.edge)),
        invDirection_(1.0f / (direction_ + 0.0f)),
        invStep_(1.0f / lattice.dt),
        // What rounding may do to a place along the ray grows with the volume and with the distance from the eye.
        margin_(1e-3f + 1e-6f * (static_cast<float>(glm::max(dims.x, glm::max(dims.y, dims.z))) + lattice.t0 + lattice.length) /
                            lattice.dt) {}

  /// The first sample of `lattice` from `i` on that may be visible; its count if there is none.
  WARPSCOPE_HD int skip(int i, const RayLattice& lattice) const {
    if (cells_.distances == nullptr) return i;
    while (i < lattice.count) {
      const float t = lattice.t(i);
      glm::ivec3 cell;
      for (int axis = 0; axis < 3; ++axis) {
        const float place = mulAdd(t, direction_[axis], origin_[axis]);  // the very place that is sampled: edges are powers of two
        cell[axis] = minOf(truncated(maxOf(place, 0.0f)), cells_.dims[axis] - 1);
      }
      const int distance = cells_.distances[(size_t(cell.z) * cells_.dims.y + cell.y) * cells_.dims.x + cell.x];
      if (distance == 0) return i;
      // Everything less than `distance` cells away is empty: go on where the ray leaves that block. What lies within rounding of the
      // block's border is looked at for itself.
      float exit = lattice.t0 + lattice.length + lattice.dt;
      for (int axis = 0; axis < 3; ++axis) {
        const int bound = cell[axis] + (direction_[axis] < 0.0f ? 1 - distance : distance);
        const float leaves = (converted(bound) - origin_[axis]) * invDirection_[axis];
        if (leaves < exit) exit = leaves;  // false for NaN: parallel to this side
      }
      const float index = (exit - lattice.t0) * invStep_ - 0.5f - margin_;
      // Compared as floats: where the ray hardly moves along an axis, the number may be beyond any integer.
      if (!(index < static_cast<float>(lattice.count)))
        i = lattice.count;
      else if (index > static_cast<float>(i + 1))
        i = static_cast<int>(std::ceil(index));
      else
        ++i;
    }
    return i;
  }

 private:
  EmptyCells cells_;
  glm::vec3 origin_{0.0f};  // in cells
  glm::vec3 direction_{0.0f};
  glm::vec3 invDirection_{0.0f};
  float invStep_ = 1.0f;
  float margin_ = 0.0f;  // in steps
};

}  // namespace warpscope
