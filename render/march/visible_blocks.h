// Which blocks of a picture's pixels see anything that a transfer function shows, and between what depths: other rays are not marched, nor the rest of these.
// Visible cells' outlines, drawn before the rays as in Avila, Sobierajski, Kaufman 1992 ("Towards a comprehensive volume visualization system",
// PARC); here as rectangles, from the cells at the surface of what is visible. Host only.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/core/box.h"
#include "render/core/pixel_grid.h"
#include "render/march/cell_block.h"
#include "render/march/empty_space.h"
#include "render/march/lattice.h"

namespace warpscope {

/// Boxes in voxel coordinates that hold every place at which a ray may enter what is visible. Made once for a transfer function.
///
/// A cell with visible cells at all six faces is left out: whatever enters it through a face, an edge or a corner comes through a point of a visible
/// cell that has a hidden one at a face. Boxes are of 1, 2, 4 ... cells a side, so that there are not too many.
std::vector<Box> visibleSurface(const EmptyCells& cells, const glm::ivec3& voxels);

/// Forward depths behind a near plane.
struct VisibleDepths {
  float nearest = 0.0f;
  float farthest = 0.0f;

  bool isEmpty() const { return !(nearest <= farthest); }
};

class VisibleBlocks {
 public:
  static constexpr uint32_t kSide = 8;  ///< pixels

  /// `surface` is visibleSurface()'s; `lower` and `voxelEdges` turn its coordinates into volume space. Where the grid's near
  /// plane is the eye's own, rays may begin in the middle of what is visible, and everything counts as seen; any other lies
  /// in front of the volume (depthRangeOf()).
  VisibleBlocks(const PixelGrid& pixels, uint32_t width, uint32_t height, std::span<const Box> surface, const glm::vec3& lower,
                const glm::vec3& voxelEdges);

  /// Where rays of the pixel's block may be in visible cells: nowhere else.
  const VisibleDepths& at(uint32_t x, uint32_t y) const { return depths_[size_t{y / kSide} * columns_ + x / kSide]; }

 private:
  /// False where everything counts as seen.
  bool draw(const PixelGrid& pixels, uint32_t width, uint32_t height, std::span<const Box> surface, const glm::vec3& lower, const glm::vec3& voxelEdges);

  uint32_t columns_ = 0;
  std::vector<VisibleDepths> depths_;
};

/// The samples of a ray, which has this cosine (PixelRay), that may lie between the depths. Places in steps are off by some 2^-21 of themselves: one
/// sample more at either end is beyond that up to 2^20 steps from the near plane, and rays that reach farther are taken whole.
inline SampleSpan samplesBetween(const VisibleDepths& depths, float cosine, const RayLattice& lattice) {
  const float perUnit = 1.0f / lattice.dt, last = static_cast<float>(lattice.count);
  if (!((lattice.t0 + lattice.length) * perUnit < 0x1p20f)) return {0, lattice.count};
  const float first = (depths.nearest / cosine - lattice.t0) * perUnit - 1.5f;
  const float beyond = (depths.farthest / cosine - lattice.t0) * perUnit + 1.5f;
  return {static_cast<int>(minOf(maxOf(first, 0.0f), last)), static_cast<int>(minOf(maxOf(beyond, 0.0f), last))};
}

}  // namespace warpscope
