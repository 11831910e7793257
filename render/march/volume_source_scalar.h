// What a ray sees of a volume, one sample at a time: the source that march.h's loop takes on a device, where the rays are the vector.
// The same formulas in the same order as volume_source.h, so that both give the same bits.
#pragma once

#include "render/core/ray.h"
#include "render/core/transfer_function.h"
#include "render/march/empty_space.h"
#include "render/march/volume_view.h"

namespace warpscope {

/// kHasHoles: some voxels are not finite and are left out of interpolation.
template <class Voxel, bool kHasHoles>
class ScalarVolumeSource {
 public:
  static constexpr int kBatch = 1;

  WARPSCOPE_HD ScalarVolumeSource(const VolumeView<Voxel>& view, const Ray& ray, const RayLattice& lattice)
      : view_(view),
        lattice_(lattice),
        origin_(view.voxelOrigin(ray)),
        direction_(view.voxelDirection(ray)),
        emptySpace_(view.cells, origin_, direction_, view.dims, lattice) {}

  WARPSCOPE_HD int skip(int i) {
    if (i < lookAgainAt_) return i;
    i = emptySpace_.skip(i, lattice_);
    lookAgainAt_ = i + kSamplesPerLook;
    return i;
  }

  WARPSCOPE_HD uint32_t classify(int i, int) {
    const float t = lattice_.t(i);
    int index[3];
    float weight[3];
    for (int axis = 0; axis < 3; ++axis)
      axisCell(origin_[axis] + t * direction_[axis], view_.dims[axis], index[axis], weight[axis]);
    // From a voxel to the next along each axis, where there is one.
    const uint32_t dx = view_.dims.x > 1 ? 1 : 0;
    const uint32_t dy = view_.dims.y > 1 ? static_cast<uint32_t>(view_.dims.x) : 0;
    const size_t strideZ = static_cast<size_t>(view_.dims.x) * static_cast<size_t>(view_.dims.y);
    const size_t dz = view_.dims.z > 1 ? strideZ : 0;
    const Voxel* near = view_.voxels + (static_cast<size_t>(index[2]) * strideZ +
                                        static_cast<size_t>(index[1]) * static_cast<uint32_t>(view_.dims.x) +
                                        static_cast<size_t>(index[0]));
    const Voxel* far = near + dz;
    const float corner[8] = {interpolant(near[0], view_.scale),       interpolant(near[dx], view_.scale),
                             interpolant(near[dy], view_.scale),      interpolant(near[dy + dx], view_.scale),
                             interpolant(far[0], view_.scale),        interpolant(far[dx], view_.scale),
                             interpolant(far[dy], view_.scale),       interpolant(far[dy + dx], view_.scale)};
    float value;
    if constexpr (kHasHoles) {
      value = trilinearOfFinite(corner, weight[0], weight[1], weight[2]);
      if (!isFiniteVoxel(value)) return 0;
    } else {
      value = trilinear(corner, weight[0], weight[1], weight[2]);
    }
    index_ = transferIndex(unitFromInterpolant<Voxel>(value, view_.scale));
    alpha_ = view_.tableAlpha[index_];
    return alpha_ > 0.0f ? 1u : 0u;
  }

  WARPSCOPE_HD float alpha(int) const { return alpha_; }
  WARPSCOPE_HD glm::vec3 color(int) const { return glm::vec3(view_.table[index_]); }

 private:
  /// What lies in one cell is not looked up again for every sample; looking less often only makes more samples be looked at.
  static constexpr int kSamplesPerLook = 4;

  const VolumeView<Voxel>& view_;
  const RayLattice& lattice_;
  glm::vec3 origin_;     // in voxel coordinates
  glm::vec3 direction_;  // voxels per unit of t
  EmptySpace emptySpace_;
  int lookAgainAt_ = 0;
  int index_ = 0;
  float alpha_ = 0.0f;
};

}  // namespace warpscope
