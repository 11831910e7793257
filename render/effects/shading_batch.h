// Shading of a batch of samples at once, on the CPU: voxels are loaded one sample at a time, all else is vectors.
// The formulas of shading.h, so that both give the same bits.
#pragma once

#include <bit>
#include <cstring>

#include "render/core/counters.h"
#include "render/core/simd.h"
#include "render/effects/shading.h"

namespace warpscope {

/// What light makes of the samples that a source has looked at.
template <class Source>
class LitBatch {
 public:
  static constexpr int kLanes = Source::kBatch;
  static_assert(kLanes == kBatchLanes);

  LitBatch() {}  // a ray that meets nothing has nothing to set

  /// Looks at samples i + k of the lattice, of which bit k of `visible` is set; none of them is the last.
  template <class Voxel>
  void look(const ShadingSetup& setup, const VolumeView<Voxel>& view, const Ray& ray, const RayLattice& lattice, int i, uint32_t visible) {
    if (!isUsed_) {
      isUsed_ = true;
      std::memset(own_, 0, sizeof own_);  // of lanes that nobody sees; later they are of an earlier batch
      std::memset(below_, 0, sizeof below_);
      std::memset(above_, 0, sizeof above_);
    }
    WARPSCOPE_COUNT(gradients, std::popcount(visible));
    WARPSCOPE_COUNT(voxels, 32 * std::popcount(visible));
    alignas(64) float t[kLanes];
    for (int k = 0; k < kLanes; ++k) t[k] = lattice.tOfWholeStep(i + k);
    const FloatBatch distance = FloatBatch::load_aligned(t);
    const glm::vec3 origin = view.voxelOrigin(ray), direction = view.voxelDirection(ray);
    IntBatch index[3];
    FloatBatch weight[3];
    for (int axis = 0; axis < 3; ++axis)
      axisCell(mulAdd(distance, FloatBatch(direction[axis]), FloatBatch(origin[axis])), view.ends[axis], index[axis], weight[axis]);
    alignas(64) int32_t at[3][kLanes];
    for (int axis = 0; axis < 3; ++axis) index[axis].store_aligned(at[axis]);
    for (uint32_t lanes = visible; lanes != 0; lanes &= lanes - 1) {
      const int k = std::countr_zero(lanes);
      const int ofLane[3] = {at[0][k], at[1][k], at[2][k]};
      GradientStencil<float> stencil;
      loadStencil<false>(view, ofLane, stencil);
      if constexpr (Source::kLeavesOutHoles) replaceMissing(stencil);
      for (int c = 0; c < 8; ++c) own_[c][k] = stencil.own[c];
      for (int axis = 0; axis < 3; ++axis)
        for (int c = 0; c < 4; ++c) {
          below_[axis][c][k] = stencil.below[axis][c];
          above_[axis][c][k] = stencil.above[axis][c];
        }
    }
    GradientStencil<FloatBatch> stencil;
    for (int c = 0; c < 8; ++c) stencil.own[c] = FloatBatch::load_aligned(own_[c]);
    for (int axis = 0; axis < 3; ++axis)
      for (int c = 0; c < 4; ++c) {
        stencil.below[axis][c] = FloatBatch::load_aligned(below_[axis][c]);
        stencil.above[axis][c] = FloatBatch::load_aligned(above_[axis][c]);
      }
    FloatBatch gradient[3], toEye[3], place[3];
    gradientOf(stencil, weight, gradient);
    for (int axis = 0; axis < 3; ++axis) {
      toEye[axis] = FloatBatch(-ray.direction[axis]);
      place[axis] = mulAdd(distance, FloatBatch(ray.direction[axis]), FloatBatch(ray.origin[axis]));
    }
    const LightFactors<FloatBatch> factors = lightFactors(setup, gradient, toEye, place);
    factors.kept.store_aligned(kept_);
    factors.white.store_aligned(white_);
  }

  glm::vec3 shade(const ClassifiedSample& sample, int k) const { return Lit::lit(kept_[k], white_[k], sample); }

 private:
  bool isUsed_ = false;
  alignas(64) float own_[8][kLanes];
  alignas(64) float below_[3][4][kLanes];
  alignas(64) float above_[3][4][kLanes];
  alignas(64) float kept_[kLanes];
  alignas(64) float white_[kLanes];
};

}  // namespace warpscope
