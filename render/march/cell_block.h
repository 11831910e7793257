// Blocks of cells into which a volume is cut, and which samples of a ray are a block's. For host and device.
#pragma once

#include "render/march/lattice.h"
#include "render/march/volume_view.h"

namespace warpscope {

/// Cells between voxels, by their lower voxels: [lower, upper) along each axis. The outermost cells have what lies beyond the outermost voxels' centres as well.
struct CellBlock {
  glm::ivec3 lower{0}, upper{0};

  bool operator==(const CellBlock&) const = default;
};

/// Whether the place at distance `t` along the ray is in a cell of the block.
template <class Voxel>
WARPSCOPE_HD inline bool isWithin(const CellBlock& block, const VolumeView<Voxel>& view, const Ray& ray, float t) {
  const glm::vec3 origin = view.voxelOrigin(ray), direction = view.voxelDirection(ray);
  for (int axis = 0; axis < 3; ++axis) {
    int index;
    float weight;
    axisCell(mulAdd(t, direction[axis], origin[axis]), view.ends[axis], index, weight);
    if (index < block.lower[axis] || index >= block.upper[axis]) return false;
  }
  return true;
}

/// Samples of a ray's lattice.
struct SampleSpan {
  int begin = 0;
  int end = 0;
};

/// The samples of the lattice that lie in cells of the block. Blocks side by side have each sample once, and those of a ray follow one another: places along a
/// ray never turn back, rounding included, and are the same bits on every processor. Without any: {0, 0}.
template <class Voxel>
WARPSCOPE_HD inline SampleSpan samplesWithin(const CellBlock& block, const VolumeView<Voxel>& view, const Ray& ray, const RayLattice& lattice) {
  const glm::vec3 origin = view.voxelOrigin(ray), direction = view.voxelDirection(ray);
  SampleSpan span{0, lattice.count};
  for (int axis = 0; axis < 3; ++axis) {
    const bool isFalling = direction[axis] < 0.0f;
    // The first sample that has come to `bound` along this axis, or gone below it.
    const auto firstAt = [&](int bound) {
      int from = span.begin, to = span.end;
      while (from < to) {
        const int middle = from + (to - from) / 2;
        int index;
        float weight;
        axisCell(mulAdd(lattice.t(middle), direction[axis], origin[axis]), view.ends[axis], index, weight);
        if (isFalling ? index < bound : index >= bound)
          to = middle;
        else
          from = middle + 1;
      }
      return from;
    };
    const int begin = firstAt(isFalling ? block.upper[axis] : block.lower[axis]);
    span = {begin, firstAt(isFalling ? block.lower[axis] : block.upper[axis])};
    if (span.begin >= span.end) return {};
  }
  return span;
}

}  // namespace warpscope
