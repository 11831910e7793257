// What a ray sees of a volume, batch by batch: the source that march.h's loop takes on the CPU.
// Positions, weights, interpolation and table indices of a batch are vectors (simd.h); voxels are loaded one lane at a time.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "render/core/counters.h"
#include "render/core/ray.h"
#include "render/core/simd.h"
#include "render/core/simd_lanes.h"
#include "render/core/transfer_table.h"
#include "render/effects/shading_batch.h"
#include "render/march/empty_space.h"
#include "render/march/march_arithmetic.h"
#include "render/march/volume_view.h"
#include "render/march/voxel_words.h"
#include "render/volume/voxel_access.h"

namespace warpscope {

/// kHasHoles: some voxels are not finite and are left out of interpolation.
template <class Voxel, bool kHasHoles, class MarchPolicy = StableMarch>
class VolumeSource {
 public:
  using VoxelType = Voxel;
  using March = MarchPolicy;
  static constexpr int kBatch = kBatchLanes;
  static constexpr bool kLoadsCells = false;
  static constexpr bool kLeavesOutHoles = kHasHoles;

  VolumeSource(const VolumeView<Voxel>& view, const Ray& ray, const RayLattice& lattice)
      : view_(view),
        lattice_(lattice),
        origin_(view.voxelOrigin(ray)),
        direction_(view.voxelDirection(ray)),
        places_(lattice),
        emptySpace_(view.cells, origin_, direction_, lattice) {
    const size_t dx = view.dims.x > 1 ? 1 : 0;
    const size_t dy = view.dims.y > 1 ? static_cast<size_t>(view.dims.x) : 0;
    const size_t dz = view.dims.z > 1 ? static_cast<size_t>(view.dims.x) * view.dims.y : 0;
    for (int i = 0; i < 8; ++i) offsets_[i] = (i & 1 ? dx : 0) + (i & 2 ? dy : 0) + (i & 4 ? dz : 0);
  }

  int skip(int i) const { return emptySpace_.skip(i, lattice_); }
  /// The same by one leap at most: what it comes to may show nothing either.
  int leap(int i) const { return emptySpace_.leapFrom(i, lattice_); }

  uint32_t classify(int i, int n) {
    alignas(64) float t[kBatch];
    if constexpr (March::kPlacesByIndex) {
      for (int k = 0; k < kBatch; ++k) t[k] = lattice_.tOfWholeStep(i + k);
    } else {
      for (int k = 0; k < kBatch; ++k) t_[k] = t[k] = k < n ? places_.next(lattice_, i + k) : t[n - 1];
    }
    return classifyAt(FloatBatch::load_aligned(t)) & ((uint32_t{2} << (n - 1)) - 1);
  }
  bool classifyLast() { return (classifyAt(FloatBatch(lattice_.t(lattice_.count - 1))) & 1) != 0; }

  /// What is interpolated at samples i .. i + kBatch - 1, the lattice's last taken for a whole step, and beyond it where the ray would be; not finite
  /// where there is no value. And at the last one.
  FloatBatch values(int i) {
    alignas(64) float t[kBatch];
    for (int k = 0; k < kBatch; ++k) t[k] = lattice_.tOfWholeStep(i + k);
    return valuesAt(FloatBatch::load_aligned(t));
  }
  FloatBatch valuesAt(const FloatBatch& distance) {
    WARPSCOPE_COUNT(samples, kBatch);
    WARPSCOPE_COUNT(voxels, 8 * kBatch);
    if constexpr (kHasHoles) WARPSCOPE_COUNT(finiteChecks, kBatch);
    IntBatch index[3];
    FloatBatch weight[3];
    for (int axis = 0; axis < 3; ++axis)
      axisCell(mulAdd(distance, FloatBatch(direction_[axis]), FloatBatch(origin_[axis])), view_.ends[axis], index[axis], weight[axis]);
    const Voxel* places[kBatch];
    locate(index, places);
    if constexpr (kHasHoles)
      return blendFinite(places, weight);
    else
      return blend(places, weight);
  }
  float valueOfLast() {
    alignas(64) float value[kBatch];
    valuesAt(FloatBatch(lattice_.t(lattice_.count - 1))).store_aligned(value);
    return value[0];
  }

  float alpha(int k) const { return alpha_[k]; }
  float unitAlpha(int k) const { return view_.transfer.unitAlphas[index_[k]]; }
  glm::vec3 color(int k) const { return glm::vec3(view_.transfer.entries[index_[k]]); }
  float t(int k) const { return t_[k]; }

  /// The volume, for what a sample's light needs beside its class.
  const VolumeView<Voxel>& view() const { return view_; }

 private:
  /// Looks at the samples at these distances; a bit is set for each that has opacity.
  uint32_t classifyAt(const FloatBatch& distance) {
    const FloatBatch value = valuesAt(distance);
    const IntBatch bin = view_.transfer.binOf(value);
    bin.store_aligned(index_);
    const FloatBatch alpha = gathered(view_.transfer.alphas, bin);
    alpha.store_aligned(alpha_);
    uint32_t visible = bitsOf(alpha > FloatBatch(0.0f)), refined = bitsOf(alpha < FloatBatch(0.0f));
    if constexpr (kHasHoles) {
      visible &= ~missing_;
      refined &= ~missing_;
    }
    return refined == 0 ? visible : visible | refine(value, refined);
  }

  /// Tells the bins of these lanes apart further; a bit is set for each that has opacity.
  uint32_t refine(const FloatBatch& value, uint32_t lanes) {
    if (!view_.transfer.isRefined) return 0;
    alignas(64) float values[kBatch];
    value.store_aligned(values);
    uint32_t visible = 0;
    for (; lanes != 0; lanes &= lanes - 1) {
      const int k = std::countr_zero(lanes);
      WARPSCOPE_COUNT(refinements, 1);
      index_[k] = view_.transfer.refined(alpha_[k], values[k]);
      alpha_[k] = view_.transfer.alphas[index_[k]];
      visible |= static_cast<uint32_t>(alpha_[k] > 0.0f) << k;
    }
    return visible;
  }

  void locate(const IntBatch (&index)[3], const Voxel* (&places)[kBatch]) const {
    alignas(64) int32_t at[3][kBatch];
    for (int axis = 0; axis < 3; ++axis) index[axis].store_aligned(at[axis]);
    const size_t strideY = static_cast<size_t>(view_.dims.x);
    const size_t strideZ = strideY * view_.dims.y;
    for (int k = 0; k < kBatch; ++k)
      places[k] = view_.voxels + (static_cast<size_t>(at[2][k]) * strideZ + static_cast<size_t>(at[1][k]) * strideY +
                                  static_cast<size_t>(at[0][k]));
  }

  FloatBatch blend(const Voxel* const (&places)[kBatch], const FloatBatch (&weight)[3]) const {
    FloatBatch corner[8];
    if (kHasPairs<Voxel> && view_.dims.x > 1) {
      if constexpr (kHasPairs<Voxel>) {
        alignas(64) uint32_t pairs[4][kBatch];
        for (int k = 0; k < kBatch; ++k)
          for (int row = 0; row < 4; ++row) pairs[row][k] = loadWord<2>(places[k] + offsets_[2 * row]);
        for (int row = 0; row < 4; ++row) {
          const UintBatch pair = UintBatch::load_aligned(pairs[row]);
          corner[2 * row] = voxelsOf<Voxel, 2, 0>(pair);
          corner[2 * row + 1] = voxelsOf<Voxel, 2, 1>(pair);
        }
      }
    } else {
      alignas(64) float values[8][kBatch];
      for (int k = 0; k < kBatch; ++k)
        for (int i = 0; i < 8; ++i) values[i][k] = interpolant(places[k][offsets_[i]], view_.scale);
      for (int i = 0; i < 8; ++i) corner[i] = FloatBatch::load_aligned(values[i]);
    }
    return trilinear(corner, weight[0], weight[1], weight[2]);
  }

  /// As blend, for voxels that may not be finite; notes where there is no value.
  FloatBatch blendFinite(const Voxel* const (&places)[kBatch], const FloatBatch (&weight)[3]) {
    alignas(64) float weights[3][kBatch];
    alignas(64) float values[kBatch];
    uint32_t missing = 0;
    for (int axis = 0; axis < 3; ++axis) weight[axis].store_aligned(weights[axis]);
    for (int k = 0; k < kBatch; ++k) {
      float corner[8];
      for (int i = 0; i < 8; ++i) corner[i] = interpolant(places[k][offsets_[i]], view_.scale);
      values[k] = trilinearOfFinite(corner, weights[0][k], weights[1][k], weights[2][k]);
      missing |= static_cast<uint32_t>(!isFiniteVoxel(values[k])) << k;
    }
    missing_ = missing;
    return FloatBatch::load_aligned(values);
  }

  const VolumeView<Voxel>& view_;
  const RayLattice& lattice_;
  glm::vec3 origin_;     // in voxel coordinates
  glm::vec3 direction_;  // voxels per unit of t
  typename March::Places places_;
  EmptySpace emptySpace_;
  size_t offsets_[8];    // from a voxel to those that are blended with it, x fastest
  alignas(64) int32_t index_[kBatch];
  alignas(64) float alpha_[kBatch];
  uint32_t missing_ = 0;  // bit k: the k-th has no value
  float t_[March::kPlacesByIndex ? 1 : kBatch];  // of what was looked at last
};

/// Shaded a batch at a time.
template <class Light, class Source>
struct BatchedLight {
  const Light& light;
  LitBatch<Light, Source> batch{};

  template <class Path>
  void look(const Path& path, const Source& source, int i, uint32_t visible) {
    batch.look(light, source.view(), path.ray, path.lattice, i, visible);
  }
  glm::vec3 shade(const ClassifiedSample& sample, const Ray&, const Source&, int k) const { return batch.shade(sample, k); }
};
template <class Voxel, bool kHasHoles>
struct LightOnSource<Lit, VolumeSource<Voxel, kHasHoles, StableMarch>> : BatchedLight<Lit, VolumeSource<Voxel, kHasHoles, StableMarch>> {};
template <class Voxel, bool kHasHoles>
struct LightOnSource<ShadowedLit, VolumeSource<Voxel, kHasHoles, StableMarch>> : BatchedLight<ShadowedLit, VolumeSource<Voxel, kHasHoles, StableMarch>> {};

}  // namespace warpscope
