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
  const float perStep = 1.0f / lattice.dt;
  SampleSpan span{0, lattice.count};
  for (int axis = 0; axis < 3; ++axis) {
    const bool isFalling = direction[axis] < 0.0f;
    // Whether a sample has come to `bound` along this axis, or gone below it: once it has, all that follow have.
    const auto isBeyond = [&](int i, int bound) {
      int index;
      float weight;
      axisCell(mulAdd(lattice.t(i), direction[axis], origin[axis]), view.ends[axis], index, weight);
      return isFalling ? index < bound : index >= bound;
    };
    const auto firstBeyond = [&](int bound) {
      int from = span.begin, to = span.end;
      if (direction[axis] == 0.0f) return from < to && isBeyond(from, bound) ? from : to;
      // Where it ought to be; then a look at what it and its neighbours really are, which halves what is left where rounding has gone farther.
      const float guess = ((static_cast<float>(bound) - origin[axis]) / direction[axis] - lattice.t0) * perStep;
      const int about = static_cast<int>(minOf(maxOf(guess, static_cast<float>(from)), static_cast<float>(to)));
      for (int i = maxOf(about - 1, from); i <= about + 1 && from < to && i < to; ++i)
        if (isBeyond(i, bound))
          to = i;
        else
          from = i + 1;
      while (from < to) {
        const int middle = from + (to - from) / 2;
        if (isBeyond(middle, bound))
          to = middle;
        else
          from = middle + 1;
      }
      return from;
    };
    const int begin = firstBeyond(isFalling ? block.upper[axis] : block.lower[axis]);
    span = {begin, firstBeyond(isFalling ? block.lower[axis] : block.upper[axis])};
    if (span.begin >= span.end) return {};
  }
  return span;
}

}  // namespace warpscope
