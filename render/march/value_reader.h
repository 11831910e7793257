// A volume's value at a place along a ray: what sources of the march share that look at one sample at a time. For host and device.
// Interpolation is voxel_access.h's, in the same order wherever it is done, so that all give the same bits.
#pragma once

#include <cmath>

#include "render/core/ray.h"
#include "render/march/volume_view.h"

namespace warpscope {

template <class Voxel>
WARPSCOPE_HD inline const VoxelCell<Voxel>& cellAt(const VolumeView<Voxel>& view, const int (&index)[3]) {
  return view.blends[view.cellPlace(index)];
}

/// The values around a place, x fastest.
template <bool kByCells, class Voxel>
WARPSCOPE_HD inline void loadCorners(const VolumeView<Voxel>& view, const int (&index)[3], float (&corner)[8]) {
  if constexpr (kByCells) {
    const VoxelCell<Voxel>& cell = cellAt(view, index);
    for (int i = 0; i < 8; ++i) corner[i] = interpolant(cell.corners[i], view.scale);
  } else {
    // From a voxel to the next along each axis, where there is one.
    const glm::ivec3& dims = view.dims;
    const size_t strideZ = static_cast<size_t>(dims.x) * static_cast<size_t>(dims.y);
    const size_t dx = dims.x > 1 ? 1 : 0, dy = dims.y > 1 ? static_cast<size_t>(dims.x) : 0, dz = dims.z > 1 ? strideZ : 0;
    const Voxel* first = view.voxels + (static_cast<size_t>(index[2]) * strideZ +
                                        static_cast<size_t>(index[1]) * static_cast<uint32_t>(dims.x) + static_cast<size_t>(index[0]));
    for (int i = 0; i < 8; ++i) corner[i] = interpolant(first[(i & 1 ? dx : 0) + (i & 2 ? dy : 0) + (i & 4 ? dz : 0)], view.scale);
  }
}

/// The interpolated value between the voxel `index` and its upper neighbours; not finite where there is none. With kHasHoles voxels that are not
/// finite are left out.
template <bool kByCells, bool kHasHoles, class Voxel>
WARPSCOPE_HD inline float valueAt(const VolumeView<Voxel>& view, const int (&index)[3], const float (&weight)[3]) {
  if constexpr (kByCells && !kHasHoles) {
    return trilinear(pairsOf(cellAt(view, index), view.scale), weight[0], weight[1], weight[2]);
  } else {
    float corner[8];
    loadCorners<kByCells>(view, index, corner);
    if constexpr (kHasHoles)
      return trilinearOfFinite(corner, weight[0], weight[1], weight[2]);
    else
      return trilinear(corner, weight[0], weight[1], weight[2]);
  }
}

/// A ray through a view, which must stay.
template <class Voxel, bool kHasHoles, bool kByCells>
class ValueReader {
 public:
  WARPSCOPE_HD ValueReader(const VolumeView<Voxel>& view, const Ray& ray)
      : view_(view), origin_(view.voxelOrigin(ray)), direction_(view.voxelDirection(ray)) {}

  /// The value at distance `t`; `index` becomes the lower of the voxels it is made of.
  WARPSCOPE_HD float at(float t, int (&index)[3]) const {
    float weight[3];
    for (int axis = 0; axis < 3; ++axis) axisCell(mulAdd(t, direction_[axis], origin_[axis]), view_.ends[axis], index[axis], weight[axis]);
    return valueAt<kByCells, kHasHoles>(view_, index, weight);
  }
  WARPSCOPE_HD float at(float t) const {
    int index[3];
    return at(t, index);
  }

  WARPSCOPE_HD const VolumeView<Voxel>& view() const { return view_; }
  WARPSCOPE_HD const glm::vec3& origin() const { return origin_; }        ///< in voxel coordinates
  WARPSCOPE_HD const glm::vec3& direction() const { return direction_; }  ///< voxels per unit of t

 private:
  const VolumeView<Voxel>& view_;
  glm::vec3 origin_;
  glm::vec3 direction_;
};

/// A view together with what one mode of rendering wants besides: what a source of that mode is made with. Both must stay.
template <class Voxel, class Setup>
struct ModeView {
  const VolumeView<Voxel>& volume;
  const Setup& setup;
};

}  // namespace warpscope
