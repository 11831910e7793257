// Shading of a batch of samples at once, on the CPU: voxels are loaded one sample at a time, all else is vectors.
// The formulas of shading.h, so that both give the same bits.
#pragma once

#include <bit>

#include "render/core/counters.h"
#include "render/core/simd.h"
#include "render/effects/gradient_batch.h"
#include "render/effects/shading.h"

namespace warpscope {

/// What light, Lit or ShadowedLit, makes of the samples that a source has looked at.
template <class Light, class Source>
class LitBatch {
 public:
  static constexpr int kLanes = kBatchLanes;
  static_assert(Source::kBatch <= kLanes);

  LitBatch() {}  // a ray that meets nothing has nothing to set

  /// Looks at samples i + k of the lattice, of which bit k of `visible` is set; none of them is the last.
  void look(const Light& light, const VolumeView<typename Source::VoxelType>& view, const Ray& ray, const RayLattice& lattice, int i, uint32_t visible) {
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
    GradientStencil<FloatBatch> stencil;
    loads_.load(view, at, visible, stencil);
    FloatBatch gradient[3], toEye[3], place[3];
    gradientOf(stencil, weight, gradient);
    for (int axis = 0; axis < 3; ++axis) {
      toEye[axis] = FloatBatch(-ray.direction[axis]);
      place[axis] = mulAdd(distance, FloatBatch(ray.direction[axis]), FloatBatch(ray.origin[axis]));
    }
    const LightFactors<FloatBatch> factors = [&] {
      if constexpr (std::is_same_v<Light, Lit>) {
        return lightFactors(light.setup, gradient, toEye, place);
      } else {
        alignas(64) float places[3][kLanes], voxels[3][kLanes];
        for (int axis = 0; axis < 3; ++axis) {
          place[axis].store_aligned(places[axis]);
          mulAdd(distance, FloatBatch(direction[axis]), FloatBatch(origin[axis])).store_aligned(voxels[axis]);
        }
        return lightFactors(light.setup, gradient, toEye, place, [&](int which) {
          if (which < 0 ? light.volume.ofAmbient < 0 : light.volume.ofLight[which] < 0) return FloatBatch(1.0f);
          alignas(64) float arriving[kLanes] = {};  // of lanes that nobody sees: none
          for (uint32_t lanes = visible; lanes != 0; lanes &= lanes - 1) {
            const int k = std::countr_zero(lanes);
            arriving[k] = light.arriving(which, view, {places[0][k], places[1][k], places[2][k]}, {voxels[0][k], voxels[1][k], voxels[2][k]});
          }
          return FloatBatch::load_aligned(arriving);
        });
      }
    }();
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
