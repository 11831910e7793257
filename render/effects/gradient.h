// The gradient of a volume at any place: central differences on the lattice of voxels, interpolated. For host and device.
// Differences and their interpolation: Levoy 1988 ("Display of surfaces from volume data"); beyond the outermost voxels values are constant (voxel_access.h).
#pragma once

#include "render/core/ray.h"
#include "render/march/volume_view.h"

namespace warpscope {

/// The values that differences around a place are taken of: its cell's corners, and those of the cells beside it that are farther away.
/// Float is float or a vector of floats.
template <class Float>
struct GradientStencil {
  Float own[8];       ///< the cell's corners, x fastest
  Float below[3][4];  ///< behind the cell's lower corners along each axis; the four as of the other two axes, the first of them fastest
  Float above[3][4];  ///< beyond its upper corners, likewise
};

/// The corner of a cell that is the `corner`-th of the four at its lower (`upper`: upper) face across `axis`.
WARPSCOPE_HD constexpr int cornerAcross(int axis, int corner, int upper) {
  const int first = corner & 1, second = corner >> 1;
  return axis == 0 ? upper + 2 * first + 4 * second : axis == 1 ? first + 2 * upper + 4 * second : first + 2 * second + 4 * upper;
}

/// What a component of gradientOf() is off by, relative to the largest value's magnitude, in units for a voxel: half of the sum of two
/// differences' roundings (a difference is at most twice as large) and the three interpolations', 9 for values twice as large.
inline constexpr double kGradientError = 20.001 * 0x1p-24;

/// Along each axis, interpolants for a voxel's edge. `weight`: the upper corners'. Where all values are equal it is 0.
template <class Float>
WARPSCOPE_HD inline void gradientOf(const GradientStencil<Float>& s, const Float (&weight)[3], Float (&gradient)[3]) {
  for (int axis = 0; axis < 3; ++axis) {
    const int a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;
    Float twice[4];
    for (int corner = 0; corner < 4; ++corner) {
      const Float lower = s.own[cornerAcross(axis, corner, 1)] - s.below[axis][corner];
      const Float upper = s.above[axis][corner] - s.own[cornerAcross(axis, corner, 0)];
      twice[corner] = lerp(lower, upper, weight[axis]);
    }
    gradient[axis] = Float(0.5f) * lerp(lerp(twice[0], twice[1], weight[a]), lerp(twice[2], twice[3], weight[a]), weight[b]);
  }
}

/// A cell's corners, or those of small voxels raised: gradients are made of differences alone.
template <class Voxel>
WARPSCOPE_HD inline void readCorners(const VoxelCell<Voxel>& cell, const ValueScale& scale, float (&corners)[8]) {
  if constexpr (kIsRaised<Voxel>)
    raisedCorners(cell, corners);
  else
    for (int i = 0; i < 8; ++i) corners[i] = interpolant(cell.corners[i], scale);
}

/// Reads the stencil of the cell at `index`; all its values may be off by the same. Outside the volume the outermost voxels count once more.
template <bool kByCells, class Voxel>
WARPSCOPE_HD inline void loadStencil(const VolumeView<Voxel>& view, const int (&index)[3], GradientStencil<float>& s) {
  if constexpr (kByCells) {
    const uint32_t stride[3] = {1, view.cellStrideY(), view.cellStrideZ()};
    const uint32_t own = view.cellPlace(index);
    readCorners(view.blends[own], view.scale, s.own);
    for (int axis = 0; axis < 3; ++axis) {
      float before[8], behind[8];
      readCorners(view.blends[index[axis] > 0 ? own - stride[axis] : own], view.scale, before);
      readCorners(view.blends[index[axis] < view.ends[axis].lastCell ? own + stride[axis] : own], view.scale, behind);
      for (int corner = 0; corner < 4; ++corner) {
        s.below[axis][corner] = before[cornerAcross(axis, corner, 0)];
        s.above[axis][corner] = behind[cornerAcross(axis, corner, 1)];
      }
    }
  } else {
    const size_t stride[3] = {1, static_cast<size_t>(view.dims.x), static_cast<size_t>(view.dims.x) * static_cast<size_t>(view.dims.y)};
    const Voxel* const first = view.voxels + (static_cast<size_t>(index[2]) * stride[2] + static_cast<size_t>(index[1]) * stride[1] + static_cast<size_t>(index[0]));
    size_t step[3], back[3], ahead[3];  // to the upper corner, to the voxel behind the lower, from the lower to the one beyond the upper
    for (int axis = 0; axis < 3; ++axis) {
      step[axis] = view.dims[axis] > 1 ? stride[axis] : 0;
      back[axis] = index[axis] > 0 ? stride[axis] : 0;
      ahead[axis] = step[axis] + (index[axis] + 2 < view.dims[axis] ? stride[axis] : 0);
    }
    for (int i = 0; i < 8; ++i) s.own[i] = interpolant(first[(i & 1 ? step[0] : 0) + (i & 2 ? step[1] : 0) + (i & 4 ? step[2] : 0)], view.scale);
    for (int axis = 0; axis < 3; ++axis) {
      const int a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;
      for (int corner = 0; corner < 4; ++corner) {
        const Voxel* const place = first + ((corner & 1 ? step[a] : 0) + (corner & 2 ? step[b] : 0));
        s.below[axis][corner] = interpolant(*(place - back[axis]), view.scale);
        s.above[axis][corner] = interpolant(place[ahead[axis]], view.scale);
      }
    }
  }
}

/// Differences over a voxel that is not finite become 0.
WARPSCOPE_HD inline void replaceMissing(GradientStencil<float>& s) {
  float nearest = 0.0f;
  for (int i = 8; i-- > 0;) nearest = isFiniteVoxel(s.own[i]) ? s.own[i] : nearest;
  for (float& own : s.own) own = isFiniteVoxel(own) ? own : nearest;
  for (int axis = 0; axis < 3; ++axis)
    for (int corner = 0; corner < 4; ++corner) {
      float& below = s.below[axis][corner];
      float& above = s.above[axis][corner];
      if (!isFiniteVoxel(below)) below = s.own[cornerAcross(axis, corner, 0)];
      if (!isFiniteVoxel(above)) above = s.own[cornerAcross(axis, corner, 1)];
    }
}

/// The gradient at a place, along the volume's axes, interpolants a voxel. With kHasHoles differences over a voxel that is not finite are 0.
template <bool kByCells, bool kHasHoles, class Voxel>
WARPSCOPE_HD inline void gradientIn(const VolumeView<Voxel>& view, const SampleCell& cell, float (&gradient)[3]) {
  GradientStencil<float> stencil;
  loadStencil<kByCells>(view, cell.index, stencil);
  if constexpr (kHasHoles) replaceMissing(stencil);
  gradientOf(stencil, cell.weight, gradient);
}

/// The same where a ray is at distance `t`.
template <bool kByCells, bool kHasHoles, class Voxel>
WARPSCOPE_HD inline void gradientAt(const VolumeView<Voxel>& view, const Ray& ray, float t, float (&gradient)[3]) {
  const glm::vec3 origin = view.voxelOrigin(ray), direction = view.voxelDirection(ray);
  SampleCell cell;
  for (int axis = 0; axis < 3; ++axis) axisCell(mulAdd(t, direction[axis], origin[axis]), view.ends[axis], cell.index[axis], cell.weight[axis]);
  gradientIn<kByCells, kHasHoles>(view, cell, gradient);
}

}  // namespace warpscope
