// What a ray sees of a volume, one sample at a time: the source that march.h's loop takes on a device, where the rays are the vector.
// The same formulas in the same order as volume_source.h, so that both give the same bits.
#pragma once

#include "render/core/counters.h"
#include "render/core/ray.h"
#include "render/core/transfer_table.h"
#include "render/march/empty_space.h"
#include "render/march/march_arithmetic.h"
#include "render/march/value_reader.h"

namespace warpscope {

/// The colour of a table's entry.
WARPSCOPE_HD inline glm::vec3 colorOfEntry(const TransferLookup& table, int index) {
#if defined(__CUDA_ARCH__)
  const float4 entry = reinterpret_cast<const float4*>(table.entries)[index];  // one wide load; device memory is aligned
  return {entry.x, entry.y, entry.z};
#else
  return glm::vec3(table.entries[index]);
#endif
}

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
        emptySpace_(view.emptyCellsTowards(direction_), origin_, direction_, lattice) {}

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
  WARPSCOPE_HD glm::vec3 color(int) const { return colorOfEntry(view_.transfer, index_); }

  WARPSCOPE_HD float t(int) const { return t_; }

  /// The volume, for what a sample's light needs beside its class.
  WARPSCOPE_HD const VolumeView<Voxel>& view() const { return view_; }
  /// Where the sample is that was looked at last.
  WARPSCOPE_HD const SampleCell& cell() const { return cell_; }

 private:
  /// Looks at the i-th sample, at distance t.
  WARPSCOPE_HD void lookAt(int i, float t) {
    int(&index)[3] = cell_.index;
    float(&weight)[3] = cell_.weight;
    for (int axis = 0; axis < 3; ++axis)
      axisCell(mulAdd(t, direction_[axis], origin_[axis]), view_.ends[axis], index[axis], weight[axis]);
    // One place for both: rays beside each other leap and look in the same turns of the loop. What is visible is not asked again.
    if (!(alpha_ > 0.0f) && emptySpace_.isKnown()) {
      leapTo_ = emptySpace_.leapFromVoxel(i, index, lattice_);
      if (leapTo_ > i) return;
    }
    WARPSCOPE_COUNT(samples, 1);
    WARPSCOPE_COUNT(voxels, 8);
    if constexpr (kHasHoles) WARPSCOPE_COUNT(finiteChecks, 1);
    const float value = valueAt<kByCells, kHasHoles>(view_, index, weight);
    if constexpr (kHasHoles)
      if (!isFiniteVoxel(value)) {
        alpha_ = 0.0f;
        return;
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

  const VolumeView<Voxel>& view_;
  const RayLattice& lattice_;
  glm::vec3 origin_;     // in voxel coordinates
  glm::vec3 direction_;  // voxels per unit of t
  typename March::Places places_;
  EmptySpace emptySpace_;
  SampleCell cell_;  // of the sample that was looked at last
  int leapTo_ = 0;
  int index_ = 0;
  float alpha_ = 0.0f;  // of the sample that was looked at last
  float t_ = 0.0f;      // likewise; unused where places go by index
};

}  // namespace warpscope
