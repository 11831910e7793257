// Pre-integrated classification on the CPU: a batch of borders gives the steps between them.
// The formulas of segment_source.h, in the same order: the same bits as one step at a time.
#pragma once

#include <algorithm>
#include <cmath>

#include "render/effects/segment_source.h"
#include "render/march/volume_source.h"

namespace warpscope {

/// As SegmentSource.
template <class Voxel>
class SegmentBatchSource {
 public:
  using VoxelType = Voxel;
  using March = StableMarch;
  using Setup = SegmentLookup;
  static constexpr int kBatch = kBatchLanes - 1;
  static constexpr bool kLoadsCells = false;
  static constexpr bool kLeavesOutHoles = false;

  SegmentBatchSource(const ModeView<Voxel, SegmentLookup>& view, const Ray& ray, const RayLattice& lattice)
      : lattice_(lattice), table_(view.setup), borders_(bordersOf(lattice)), values_(view.volume, ray, borders_) {}
  SegmentBatchSource(const SegmentBatchSource&) = delete;  // its parts refer to each other
  SegmentBatchSource& operator=(const SegmentBatchSource&) = delete;

  /// The first step from `i` on that may show something. One leap at a time: the step that leaves what it leaps over has to be looked at, whatever shows nothing follows.
  int skip(int i) const {
    if (i >= lattice_.count) return i;
    const int border = values_.leap(i);
    return border >= borders_.count ? lattice_.count : std::max(i, border - 1);
  }

  uint32_t classify(int i, int n) { return classifyBetween(values_.values(i)) & ((uint32_t{2} << (n - 1)) - 1); }
  bool classifyLast() {
    alignas(64) float t[kBatchLanes];
    std::ranges::fill(t, lattice_.t0 + lattice_.length);
    t[0] = borders_.tOfWholeStep(lattice_.count - 1);
    return (classifyBetween(values_.valuesAt(FloatBatch::load_aligned(t))) & 1) != 0;
  }
  float alpha(int k) const { return alpha_[k]; }
  float unitAlpha(int k) const { return alphaOf(table_, table_.unitAlphas, place(k)); }
  glm::vec3 color(int k) const { return colorOf(table_, place(k)); }

  const VolumeView<Voxel>& view() const { return values_.view(); }

 private:
  SegmentPlace place(int k) const { return {first_[k], front_[k], back_[k]}; }

  uint32_t classifyBetween(const FloatBatch& value) {
    WARPSCOPE_COUNT(segments, kBatch);
    alignas(64) float places[kBatchLanes + 1];
    table_.placeOf(value).store_aligned(places);
    places[kBatchLanes] = places[kBatchLanes - 1];
    const FloatBatch frontPlace = FloatBatch::load_aligned(places), backPlace = FloatBatch::load_unaligned(places + 1);
    const IntBatch front = truncatedWithin(frontPlace, table_.nodes - 2), back = truncatedWithin(backPlace, table_.nodes - 2);
    const IntBatch first = front * IntBatch(table_.nodes) + back;
    const FloatBatch ofFront = frontPlace - converted(front), ofBack = backPlace - converted(back);
    const float* const alphas = table_.alphas;
    const FloatBatch corners[4] = {gathered(alphas, first), gathered(alphas + 1, first), gathered(alphas + table_.nodes, first),
                                   gathered(alphas + table_.nodes + 1, first)};
    const FloatBatch alpha = minOf(blended(corners, ofFront, ofBack), FloatBatch(1.0f));
    first.store_aligned(first_);
    ofFront.store_aligned(front_);
    ofBack.store_aligned(back_);
    alpha.store_aligned(alpha_);
    return bitsOf(alpha > FloatBatch(0.0f));
  }

  const RayLattice& lattice_;
  const SegmentLookup& table_;
  const RayLattice borders_;
  VolumeSource<Voxel, false> values_;  // at borders
  alignas(64) int32_t first_[kBatchLanes];
  alignas(64) float front_[kBatchLanes];
  alignas(64) float back_[kBatchLanes];
  alignas(64) float alpha_[kBatchLanes];
};

template <class Voxel>
struct LightOnSource<Lit, SegmentBatchSource<Voxel>> : BatchedLight<Lit, SegmentBatchSource<Voxel>> {};
template <class Voxel>
struct LightOnSource<ShadowedLit, SegmentBatchSource<Voxel>> : BatchedLight<ShadowedLit, SegmentBatchSource<Voxel>> {};

}  // namespace warpscope
