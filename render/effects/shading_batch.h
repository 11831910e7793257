// Shading of a batch of samples at once, on the CPU: voxels are loaded one sample at a time, all else is vectors.
// The formulas of shading.h, so that both give the same bits.
#pragma once

#include "render/core/simd.h"
#include "render/effects/gradient_batch.h"
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
  void look(const ShadingSetup& setup, const VolumeView<typename Source::VoxelType>& view, const Ray& ray, const RayLattice& lattice, int i, uint32_t visible) {
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
    GradientStencil<FloatBatch> stencil;
    loads_.load(view, at, visible, stencil);
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
  GradientLoads<typename Source::VoxelType, Source::kLeavesOutHoles> loads_;
  alignas(64) float kept_[kLanes];
  alignas(64) float white_[kLanes];
};

}  // namespace warpscope
