// What a ray sees of a volume, one sample at a time: the source that march.h's loop takes on a device, where the rays are the vector.
// The same formulas in the same order as volume_source.h, so that both give the same bits.
#pragma once

#include "render/core/counters.h"
#include "render/core/ray.h"
#include "render/core/transfer_table.h"
#include "render/march/empty_space.h"
#include "render/march/march_arithmetic.h"
#include "render/march/volume_view.h"

namespace warpscope {

/// kHasHoles: some voxels are not finite and are left out of interpolation. kByCells: the view has cells to load from, not voxels.
/// kIsRefined: the table may have bins that are told apart further; asking costs a tenth of a march.
template <class Voxel, bool kHasHoles, bool kByCells, class MarchPolicy = StableMarch, bool kIsRefined = true>
class ScalarVolumeSource {
 public:
  using March = MarchPolicy;
  static constexpr int kBatch = 1;
  static constexpr bool kLoadsCells = kByCells;
  static constexpr bool kLeavesOutHoles = kHasHoles;

  WARPSCOPE_HD ScalarVolumeSource(const VolumeView<Voxel>& view, const Ray& ray, const RayLattice& lattice)
      : view_(view),
        lattice_(lattice),
        origin_(view.voxelOrigin(ray)),
        direction_(view.voxelDirection(ray)),
        places_(lattice),
        emptySpace_(view.cells, origin_, direction_, lattice) {}

  WARPSCOPE_HD int skip(int i) const { return maxOf(i, leapTo_); }

  WARPSCOPE_HD uint32_t classify(int i, int) {
    const float t = places_.next(lattice_, i);
    if constexpr (!March::kPlacesByIndex) t_ = t;
    lookAt(i, t);
    return alpha_ > 0.0f ? 1u : 0u;
  }
  WARPSCOPE_HD bool classifyLast() {
    lookAt(lattice_.count - 1, lattice_.t(lattice_.count - 1));
    return alpha_ > 0.0f;
  }
  WARPSCOPE_HD float alpha(int) const { return alpha_; }
  WARPSCOPE_HD float unitAlpha(int) const { return view_.transfer.unitAlphas[index_]; }
  WARPSCOPE_HD glm::vec3 color(int) const {
#if defined(__CUDA_ARCH__)
    const float4 entry = reinterpret_cast<const float4*>(view_.transfer.entries)[index_];  // one wide load; device memory is aligned
    return {entry.x, entry.y, entry.z};
#else
    return glm::vec3(view_.transfer.entries[index_]);
#endif
  }

  WARPSCOPE_HD float t(int) const { return t_; }

  /// The volume, for what a sample's light needs beside its class.
  WARPSCOPE_HD const VolumeView<Voxel>& view() const { return view_; }

 private:
  /// Looks at the i-th sample, at distance t.
  WARPSCOPE_HD void lookAt(int i, float t) {
    int index[3];
    float weight[3];
    for (int axis = 0; axis < 3; ++axis)
      axisCell(mulAdd(t, direction_[axis], origin_[axis]), view_.ends[axis], index[axis], weight[axis]);
    // One place for both: rays beside each other leap and look in the same turns of the loop. What is visible is not asked again.
    if (!(alpha_ > 0.0f) && emptySpace_.isKnown()) {
      leapTo_ = emptySpace_.leapFromVoxel(i, index, lattice_);
      if (leapTo_ > i) return;
    }
    WARPSCOPE_COUNT(samples, 1);
    WARPSCOPE_COUNT(voxels, 8);
    float value;
    if constexpr (kHasHoles) {
      WARPSCOPE_COUNT(finiteChecks, 1);
      float corner[8];
      load(index, corner);
      value = trilinearOfFinite(corner, weight[0], weight[1], weight[2]);
      if (!isFiniteVoxel(value)) {
        alpha_ = 0.0f;
        return;
      }
    } else if constexpr (kByCells) {
      value = trilinear(pairsOf(cellAt(index), view_.scale), weight[0], weight[1], weight[2]);
    } else {
      float corner[8];
      load(index, corner);
      value = trilinear(corner, weight[0], weight[1], weight[2]);
    }
    index_ = view_.transfer.binOf(value);
    alpha_ = view_.transfer.alphas[index_];
    if constexpr (kIsRefined)
      if (alpha_ < 0.0f) {
        WARPSCOPE_COUNT(refinements, 1);
        index_ = view_.transfer.refined(alpha_, value);
        alpha_ = view_.transfer.alphas[index_];
      }
  }

  WARPSCOPE_HD const VoxelCell<Voxel>& cellAt(const int (&index)[3]) const {
    // There are never as many cells as 2^32: device_volume.h keeps larger volumes as voxels.
    const uint32_t row = static_cast<uint32_t>(index[2]) * static_cast<uint32_t>(view_.ends[1].lastCell + 1) + static_cast<uint32_t>(index[1]);
    return view_.blends[row * static_cast<uint32_t>(view_.ends[0].lastCell + 1) + static_cast<uint32_t>(index[0])];
  }

  /// The values around a place, x fastest.
  WARPSCOPE_HD void load(const int (&index)[3], float (&corner)[8]) const {
    if constexpr (kByCells) {
      const VoxelCell<Voxel>& cell = cellAt(index);
      for (int i = 0; i < 8; ++i) corner[i] = interpolant(cell.corners[i], view_.scale);
    } else {
      // From a voxel to the next along each axis, where there is one.
      const glm::ivec3& dims = view_.dims;
      const size_t strideZ = static_cast<size_t>(dims.x) * static_cast<size_t>(dims.y);
      const size_t dx = dims.x > 1 ? 1 : 0, dy = dims.y > 1 ? static_cast<size_t>(dims.x) : 0, dz = dims.z > 1 ? strideZ : 0;
      const Voxel* first = view_.voxels + (static_cast<size_t>(index[2]) * strideZ +
                                           static_cast<size_t>(index[1]) * static_cast<uint32_t>(dims.x) + static_cast<size_t>(index[0]));
      for (int i = 0; i < 8; ++i) corner[i] = interpolant(first[(i & 1 ? dx : 0) + (i & 2 ? dy : 0) + (i & 4 ? dz : 0)], view_.scale);
    }
  }

  const VolumeView<Voxel>& view_;
  const RayLattice& lattice_;
  glm::vec3 origin_;     // in voxel coordinates
  glm::vec3 direction_;  // voxels per unit of t
  typename March::Places places_;
  EmptySpace emptySpace_;
  int leapTo_ = 0;
  int index_ = 0;
  float alpha_ = 0.0f;  // of the sample that was looked at last
  float t_ = 0.0f;      // likewise; unused where places go by index
};

}  // namespace warpscope
