// Rays side by side, as many as a vector has lanes: those of pixels beside and above each other. Host only.
#pragma once

#include <limits>

#include "render/core/box.h"
#include "render/core/pixel_grid.h"
#include "render/core/ray.h"
#include "render/core/simd.h"

namespace warpscope {

/// Each with its part inside of something.
struct alignas(64) RayPacket {
  static constexpr uint32_t kColumns = kBatchLanes < 8 ? 2 : 4, kRows = kBatchLanes / kColumns;

  float originX[kBatchLanes], originY[kBatchLanes], originZ[kBatchLanes];
  float directionX[kBatchLanes], directionY[kBatchLanes], directionZ[kBatchLanes];
  float tNear[kBatchLanes], tFar[kBatchLanes];  ///< RayInterval's, also of rays that are no pixel's: misses

  Ray ray(int lane) const { return {{originX[lane], originY[lane], originZ[lane]}, {directionX[lane], directionY[lane], directionZ[lane]}}; }

  /// Those of pixels from (column, row) on, of pixels in front of (x1, y1), and their parts inside the bounds: PixelGrid::ray() and intersectBox() of each, by the same
  /// operations in the same order, so that they are the same bits. Whether one is no miss.
  bool set(const PixelGrid& grid, const Box& bounds, uint32_t column, uint32_t row, uint32_t x1, uint32_t y1) {
    using F = FloatBatch;
    using M = xsimd::batch_bool<float>;
    struct alignas(64) Places {
      float x[kBatchLanes], y[kBatchLanes];
      constexpr Places() : x(), y() {
        for (uint32_t lane = 0; lane < kBatchLanes; ++lane) x[lane] = static_cast<float>(lane % kColumns), y[lane] = static_cast<float>(lane / kColumns);
      }
    };
    static constexpr Places kPlaces;
    const F half(0.5f), one(1.0f), zero(0.0f);
    const F x = F(static_cast<float>(column)) + F::load_aligned(kPlaces.x), y = F(static_cast<float>(row)) + F::load_aligned(kPlaces.y);
    const F offsetX = (x + half - F(grid.halfWidth)) * F(grid.edge), offsetY = (F(grid.halfHeight) - (y + half)) * F(grid.edge);
    F origins[3], directions[3];
    for (int axis = 0; axis < 3; ++axis) {
      const F right = offsetX * F(grid.right[axis]), up = offsetY * F(grid.up[axis]);
      directions[axis] = F(grid.forward[axis]) + right + up;
      origins[axis] = F(grid.anchor[axis]) + F(grid.nearDepth) * (right + up);
    }
    const F cosine = one / sqrtOf(directions[0] * directions[0] + directions[1] * directions[1] + directions[2] * directions[2]);
    F from = zero, to(std::numeric_limits<float>::infinity());
    for (int axis = 0; axis < 3; ++axis) {
      directions[axis] = directions[axis] * cosine;
      const F inverse = one / (directions[axis] + zero), lower = F(bounds.lower[axis]) - origins[axis], upper = F(bounds.upper[axis]) - origins[axis];
      const M isBack = inverse < zero;
      const F t0 = selected(isBack, upper, lower) * inverse, t1 = selected(isBack, lower, upper) * inverse;
      from = selected(t0 > from, t0, from);  // false of what is no number, as in clipToSlab()
      to = selected(t1 < to, t1, to);
    }
    const M isPixel = (x < F(static_cast<float>(x1))) & (y < F(static_cast<float>(y1))) & M(!bounds.isEmpty());
    constexpr RayInterval kMiss;
    from = selected(isPixel, from, F(kMiss.tNear));
    to = selected(isPixel, to, F(kMiss.tFar));
    origins[0].store_aligned(originX), origins[1].store_aligned(originY), origins[2].store_aligned(originZ);
    directions[0].store_aligned(directionX), directions[1].store_aligned(directionY), directions[2].store_aligned(directionZ);
    from.store_aligned(tNear);
    to.store_aligned(tFar);
    return xsimd::any(from <= to);
  }
};

}  // namespace warpscope
