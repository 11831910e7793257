// What a ray sees of a volume where steps are classified by the values at their ends (segment_table.h), one step at a time: for devices.
// A step's front is the back of the one before it: one value is interpolated a step (Engel, Kraus, Ertl 2001, section 4).
#pragma once

#include "render/core/counters.h"
#include "render/core/segment_table.h"
#include "render/march/empty_space.h"
#include "render/march/march_arithmetic.h"
#include "render/march/value_reader.h"

namespace warpscope {

/// The lattice whose samples are the borders of a lattice's steps, its beginning the first; the last may lie behind the end.
WARPSCOPE_HD inline RayLattice bordersOf(const RayLattice& lattice) {
  RayLattice borders = lattice;
  borders.t0 = mulAdd(-0.5f, lattice.dt, lattice.t0);
  borders.length = (static_cast<float>(lattice.count) + 1.0f) * lattice.dt;
  borders.count = lattice.count + 1;
  return borders;
}

/// Of voxels that are all finite. kByCells: the view has cells to load from, not voxels.
template <class Voxel, bool kByCells>
class SegmentSource {
 public:
  using March = StableMarch;
  using Setup = SegmentLookup;
  static constexpr int kBatch = 1;
  static constexpr bool kLoadsCells = kByCells;
  static constexpr bool kLeavesOutHoles = false;

  WARPSCOPE_HD SegmentSource(const ModeView<Voxel, SegmentLookup>& view, const Ray& ray, const RayLattice& lattice)
      : reader_(view.volume, ray),
        lattice_(lattice),
        table_(view.setup),
        borders_(bordersOf(lattice)),
        emptySpace_(view.volume.emptyCellsTowards(reader_.direction()), reader_.origin(), reader_.direction(), borders_) {}

  WARPSCOPE_HD int skip(int i) const { return minOf(maxOf(i, leapTo_), lattice_.count); }

  WARPSCOPE_HD uint32_t classify(int i, int) {
    alpha_ = 0.0f;
    int index[3];
    float front = back_;
    if (backOf_ != i) {
      const float value = reader_.at(borders_.tOfWholeStep(i), index);
      if (leaps(i, index)) return 0;
      front = placeOf(value);
    }
    const float value = reader_.at(borders_.tOfWholeStep(i + 1), index);
    back_ = placeOf(value);
    backOf_ = i + 1;
    look(front, back_);
    if (alpha_ > 0.0f) return 1;
    leaps(i + 1, index);
    return 0;
  }
  WARPSCOPE_HD bool classifyLast() {
    const float front = placeOf(reader_.at(borders_.tOfWholeStep(lattice_.count - 1)));
    look(front, placeOf(reader_.at(lattice_.t0 + lattice_.length)));
    return alpha_ > 0.0f;
  }
  WARPSCOPE_HD float alpha(int) const { return alpha_; }
  WARPSCOPE_HD float unitAlpha(int) const { return alphaOf(table_, table_.unitAlphas, place_); }
  WARPSCOPE_HD glm::vec3 color(int) const { return colorOf(table_, place_); }

  WARPSCOPE_HD const VolumeView<Voxel>& view() const { return reader_.view(); }

 private:
  WARPSCOPE_HD float placeOf(float value) const {
    WARPSCOPE_COUNT(samples, 1);
    WARPSCOPE_COUNT(voxels, 8);
    return table_.placeOf(value);
  }
  WARPSCOPE_HD void look(float front, float back) {
    WARPSCOPE_COUNT(segments, 1);
    place_ = segmentPlace(table_, front, back);
    alpha_ = alphaOf(table_, table_.alphas, place_);
  }
  /// Where the i-th border, whose voxel is `index`, is among what shows nothing: leaps over the steps that end there. True if that is more than none.
  WARPSCOPE_HD bool leaps(int i, const int (&index)[3]) {
    if (!emptySpace_.isKnown()) return false;
    leapTo_ = emptySpace_.leapFromVoxel(i, index, borders_) - 1;  // the step in front of the border that may show something
    return leapTo_ > i;
  }

  const ValueReader<Voxel, false, kByCells> reader_;
  const RayLattice& lattice_;
  const SegmentLookup& table_;
  const RayLattice borders_;
  const EmptySpace emptySpace_;
  SegmentPlace place_;
  float alpha_ = 0.0f;
  float back_ = 0.0f;  ///< place of the value at the border that was looked at last
  int backOf_ = -1;    ///< that border
  int leapTo_ = 0;
};

}  // namespace warpscope
