// The rays of a camera's pixels side by side, as many as a vector has lanes. On the host, on all cores.
// See pixel_rays.h.
#pragma once

#include <stop_token>

#include "render/core/simd.h"
#include "render/warp/segments/pixel_rays.h"

namespace warpscope {

/// Rays of pixels beside and above each other.
struct RayPacket {
  static constexpr uint32_t kColumns = kBatchLanes < 8 ? 2 : 4, kRows = kBatchLanes / kColumns;

  Ray rays[kBatchLanes];
  RayInterval inside[kBatchLanes];  ///< parts inside the frame's bounds; misses of rays that have none or are no pixel's
  bool isAny = false;               ///< whether there is one that is no miss

  /// From the pixel (column, row) on, of those in front of (x1, y1): PixelRays::at() of each, by the same operations in the same order.
  void set(const PixelRays& from, uint32_t column, uint32_t row, uint32_t x1, uint32_t y1) {
    using F = FloatBatch;
    using M = xsimd::batch_bool<float>;
    struct Three {
      F x, y, z;
    };
    alignas(64) float columns[kBatchLanes], rows[kBatchLanes], nears[kBatchLanes], fars[kBatchLanes];
    for (uint32_t lane = 0; lane < kBatchLanes; ++lane) {
      columns[lane] = static_cast<float>(column + lane % kColumns);
      rows[lane] = static_cast<float>(row + lane / kColumns);
    }
    const PixelGrid& grid = from.pixels;
    const F half(0.5f), one(1.0f), zero(0.0f), nearDepth(grid.nearDepth), edge(grid.edge);
    const F offsetX = (F::load_aligned(columns) + half - F(grid.halfWidth)) * edge, offsetY = (F(grid.halfHeight) - (F::load_aligned(rows) + half)) * edge;
    Three origins, directions;
    const auto component = [&](int axis, F& origin, F& direction) {
      const F right = offsetX * F(grid.right[axis]), up = offsetY * F(grid.up[axis]);
      direction = F(grid.forward[axis]) + right + up;
      origin = F(grid.anchor[axis]) + nearDepth * (right + up);
    };
    component(0, origins.x, directions.x);
    component(1, origins.y, directions.y);
    component(2, origins.z, directions.z);
    const F cosine = one / sqrtOf(directions.x * directions.x + directions.y * directions.y + directions.z * directions.z);
    F tNear = zero, tFar(std::numeric_limits<float>::infinity());
    const auto clip = [&](int axis, const F& origin, F& direction) {
      direction = direction * cosine;
      const F inverse = one / (direction + zero), lower = F(from.bounds.lower[axis]) - origin, upper = F(from.bounds.upper[axis]) - origin;
      const M isBack = inverse < zero;
      const F t0 = selected(isBack, upper, lower) * inverse, t1 = selected(isBack, lower, upper) * inverse;
      tNear = selected(t0 > tNear, t0, tNear);  // false of what is no number, as in clipToSlab()
      tFar = selected(t1 < tFar, t1, tFar);
    };
    clip(0, origins.x, directions.x);
    clip(1, origins.y, directions.y);
    clip(2, origins.z, directions.z);
    tNear.store_aligned(nears);
    tFar.store_aligned(fars);
    alignas(64) float o[3][kBatchLanes], d[3][kBatchLanes];
    origins.x.store_aligned(o[0]), origins.y.store_aligned(o[1]), origins.z.store_aligned(o[2]);
    directions.x.store_aligned(d[0]), directions.y.store_aligned(d[1]), directions.z.store_aligned(d[2]);
    const bool isNowhere = from.bounds.isEmpty();
    isAny = false;
    for (uint32_t lane = 0; lane < kBatchLanes; ++lane) {
      rays[lane] = {{o[0][lane], o[1][lane], o[2][lane]}, {d[0][lane], d[1][lane], d[2][lane]}};
      const bool isPixel = column + lane % kColumns < x1 && row + lane / kColumns < y1;
      inside[lane] = isPixel && !isNowhere ? RayInterval{nears[lane], fars[lane]} : RayInterval{};
      isAny = isAny || !inside[lane].isMiss();
    }
  }
};

/// As forEachPixelRay(), of pixels beside and above each other, whose rays' ways are alike. Calls `walk(rays, inside, walked)`, where `inside` are the parts inside the
/// frame's bounds, misses for rays that have none or are no pixel's; and `take(x, y, walked)` for each pixel. Throws OperationCancelled if `stop` is set.
template <class Walk, class Take>
void forEachPixelPacket(const SampleFrame& frame, const Camera& camera, const std::stop_token& stop, const Walk& walk, const Take& take) {
  constexpr uint32_t kColumns = RayPacket::kColumns, kRows = RayPacket::kRows;
  static_assert(kRayTileSide % kColumns == 0 && kRayTileSide % kRows == 0);
  const PixelRays pixels(frame, camera);
  parallelForTiles(camera.width, camera.height, kRayTileSide, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    RayPacket packet;
    for (uint32_t row = y0; row < y1; row += kRows)
      for (uint32_t column = x0; column < x1; column += kColumns) {
        WalkedRay walked[kBatchLanes];
        exceptionsExpected([&] {
          packet.set(pixels, column, row, x1, y1);
          if (packet.isAny) walk(packet.rays, packet.inside, walked);
        });
        for (uint32_t lane = 0; lane < kBatchLanes; ++lane)
          if (const uint32_t x = column + lane % kColumns, y = row + lane / kColumns; x < x1 && y < y1) take(x, y, walked[lane]);
      }
  });
}

}  // namespace warpscope
