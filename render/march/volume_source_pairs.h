// What a ray sees of a volume, two samples at a time: the source that march.h's loop takes on a device where voxels are small and nothing is lit.
// Both of a pair are loaded before either is looked at, and a turn of the loop serves two. The formulas are volume_source_scalar.h's, and so are the bits:
// places are not held inside the volume (axisCell) where the cells around it (voxelCellAt) give the very same. Below the first voxel they do: between equal
// numbers any weight gives that number, as the weight 0 does. Beyond the last they do along x, where whole numbers of up to 16 bits are blended, of which the
// difference and what a weight of 1 makes of it are exact. Along y and z numbers are blended that have been rounded, and there places are held.
#pragma once

#include <type_traits>

#include "render/march/volume_source_scalar.h"

namespace warpscope {

/// Voxels that PairedVolumeSource may read.
template <class Voxel>
inline constexpr bool kIsPairable = std::is_integral_v<Voxel> && sizeof(Voxel) <= 2;

/// For views that have cells. Volumes have at most 2^16 voxels along an axis, so that places may be floored(). kIsRefined: as ScalarVolumeSource's.
template <class Voxel, bool kIsRefined>
class PairedVolumeSource {
  static_assert(kIsPairable<Voxel>);

 public:
  using March = StableMarch;
  static constexpr int kBatch = 2;
  static constexpr bool kLoadsCells = true;
  static constexpr bool kLeavesOutHoles = false;

  WARPSCOPE_HD PairedVolumeSource(const VolumeView<Voxel>& view, const Ray& ray, const RayLattice& lattice)
      : view_(view),
        lattice_(lattice),
        origin_(view.voxelOrigin(ray)),
        direction_(view.voxelDirection(ray)),
        lastCell_(view.ends[0].lastCell, view.ends[1].lastCell, view.ends[2].lastCell),
        strideY_(view.cellStrideY()),
        strideZ_(view.cellStrideZ()),
        first_((Floored::kRaised - 1u) * (1u + strideY_ + strideZ_)),
        emptySpace_(view.emptyCellsTowards(direction_), origin_, direction_, lattice) {
    // Where a ray enters and leaves is rounded relative to how far that is from its origin: from afar, or through voxels that are a million times as long as
    // wide, it may miss the volume's ends by voxels. Places are monotone along a ray, so that its ends tell of all of them.
    for (const int end : {0, lattice.count - 2}) {
      if (end < 0) continue;
      const glm::vec3 place = voxelAt(lattice.tOfWholeStep(end));
      for (int axis = 0; axis < 3; ++axis) isHeld_ = isHeld_ || !(place[axis] >= -1.0f && place[axis] < view.ends[axis].lastVoxel + 1.0f);
    }
  }

  /// Leaps once where the pair before ended with what is hidden. The place of the sample that it gives is kept for classify(): leaping and looking are in
  /// the same turn of the loop, so that rays which leap do not keep the others waiting.
  WARPSCOPE_HD int skip(int i) {
    if (i + 1 >= lattice_.count) return i;
    places_[0] = placeAt(i);
    if (alpha_[1] > 0.0f || !emptySpace_.isKnown()) return i;
    int index[3];
    for (int axis = 0; axis < 3; ++axis) index[axis] = maxOf(places_[0].floor[axis].index(), 0);
    const int to = emptySpace_.leapFromVoxel(i, index, lattice_);
    if (to == i || to + 1 >= lattice_.count) return to;
    places_[0] = placeAt(to);
    return to;
  }

  WARPSCOPE_HD uint32_t classify(int i, int n) {
    places_[1] = placeAt(minOf(i + 1, lattice_.count - 2));  // the last one's step may end outside
    if (isBeyond(places_[0]) || isBeyond(places_[1])) {
      hold(places_[0]);
      hold(places_[1]);
    }
    WARPSCOPE_COUNT(samples, n);
    WARPSCOPE_COUNT(voxels, 8 * n);
    look<2>();
    if (n < 2) alpha_[1] = 0.0f;
    return (alpha_[0] > 0.0f ? 1u : 0u) | (alpha_[1] > 0.0f ? 2u : 0u);
  }
  WARPSCOPE_HD bool classifyLast() {
    places_[0] = placeOf(voxelAt(lattice_.t(lattice_.count - 1)));
    hold(places_[0]);  // jitter may have moved it outside
    WARPSCOPE_COUNT(samples, 1);
    WARPSCOPE_COUNT(voxels, 8);
    look<1>();
    return alpha_[0] > 0.0f;
  }
  WARPSCOPE_HD float alpha(int k) const { return alpha_[k]; }
  WARPSCOPE_HD float unitAlpha(int k) const { return view_.transfer.unitAlphas[index_[k]]; }
  WARPSCOPE_HD glm::vec3 color(int k) const { return colorOfEntry(view_.transfer, index_[k]); }

  WARPSCOPE_HD const VolumeView<Voxel>& view() const { return view_; }

 private:
  struct Place {
    glm::vec3 voxel;
    Floored floor[3];
  };

  WARPSCOPE_HD glm::vec3 voxelAt(float t) const {
    glm::vec3 voxel;
    for (int axis = 0; axis < 3; ++axis) voxel[axis] = mulAdd(t, direction_[axis], origin_[axis]);
    return voxel;
  }
  WARPSCOPE_HD static Place placeOf(const glm::vec3& voxel) {
    Place place{voxel, {}};
    for (int axis = 0; axis < 3; ++axis) place.floor[axis] = floored(voxel[axis]);
    return place;
  }
  /// Of a whole step.
  WARPSCOPE_HD Place placeAt(int i) const {
    Place place = placeOf(voxelAt(lattice_.tOfWholeStep(i)));
    if (isHeld_) hold(place);
    return place;
  }
  /// Among the cells beyond the last voxel along y or z.
  WARPSCOPE_HD bool isBeyond(const Place& place) const {
    return place.floor[1].whole > lastCell_[1] || place.floor[2].whole > lastCell_[2];
  }
  /// As axisCell().
  WARPSCOPE_HD void hold(Place& place) const {
    for (int axis = 0; axis < 3; ++axis) {
      place.voxel[axis] = minOf(maxOf(place.voxel[axis], 0.0f), view_.ends[axis].lastVoxel);
      place.floor[axis] = floored(minOf(place.voxel[axis], lastCell_[axis]));
    }
  }

  /// Looks at the first kCount places.
  template <int kCount>
  WARPSCOPE_HD void look() {
    float value[kCount];
    for (int k = 0; k < kCount; ++k) {
      const Place& place = places_[k];
      // Floors are raised, cells begin at -1: both are taken off at once.
      const uint32_t cell = place.floor[2].raised * strideZ_ + place.floor[1].raised * strideY_ + place.floor[0].raised - first_;
      float weight[3];
      for (int axis = 0; axis < 3; ++axis) weight[axis] = place.voxel[axis] - place.floor[axis].whole;
      value[k] = trilinear(pairsOf(view_.outerBlends[cell], view_.scale), weight[0], weight[1], weight[2]);
    }
    for (int k = 0; k < kCount; ++k) index_[k] = view_.transfer.binOf(value[k]);
    for (int k = 0; k < kCount; ++k) alpha_[k] = view_.transfer.alphas[index_[k]];
    if constexpr (kIsRefined)
      for (int k = 0; k < kCount; ++k)
        if (alpha_[k] < 0.0f) {
          WARPSCOPE_COUNT(refinements, 1);
          index_[k] = view_.transfer.refined(alpha_[k], value[k]);
          alpha_[k] = view_.transfer.alphas[index_[k]];
        }
  }

  const VolumeView<Voxel>& view_;
  const RayLattice& lattice_;
  glm::vec3 origin_;     // in voxel coordinates
  glm::vec3 direction_;  // voxels per unit of t
  glm::vec3 lastCell_;   // along each axis, as AxisEnds has it
  uint32_t strideY_, strideZ_;
  uint32_t first_;  // what the cell at -1 along each axis comes to by raised floors
  EmptySpace emptySpace_;
  bool isHeld_ = false;  // wherever it is
  Place places_[2];
  int index_[2] = {0, 0};
  float alpha_[2] = {0.0f, 0.0f};  // of the samples that were looked at last
};

/// What a march of unlit samples by index reads a view through.
template <class Voxel, bool kHasHoles, bool kByCells, bool kIsRefined>
using UnlitVolumeSource =
    std::conditional_t<kByCells && !kHasHoles && kIsPairable<Voxel>, PairedVolumeSource<std::conditional_t<kIsPairable<Voxel>, Voxel, uint8_t>, kIsRefined>,
                       ScalarVolumeSource<Voxel, kHasHoles, kByCells, StableMarch, kIsRefined>>;

}  // namespace warpscope
