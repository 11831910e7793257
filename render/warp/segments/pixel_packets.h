// The rays of a camera's pixels side by side, as many as a vector has lanes. On the host, on all cores.
// See pixel_rays.h.
#pragma once

#include <stop_token>

#include "render/core/simd.h"
#include "render/warp/segments/pixel_rays.h"

namespace warpscope {

/// As forEachPixelRay(), of pixels beside and above each other, whose rays' ways are alike. Calls `walk(rays, inside, walked)`, where `inside` are the parts inside the
/// frame's bounds, misses for rays that have none or are no pixel's; and `take(x, y, walked)` for each pixel. Throws OperationCancelled if `stop` is set.
template <class Walk, class Take>
void forEachPixelPacket(const SampleFrame& frame, const Camera& camera, const std::stop_token& stop, const Walk& walk, const Take& take) {
  constexpr uint32_t kColumns = kBatchLanes < 8 ? 2 : 4, kRows = kBatchLanes / kColumns;
  static_assert(kRayTileSide % kColumns == 0 && kRayTileSide % kRows == 0);
  forEachRayTile(frame, camera, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1, const auto& rayAt) {
    for (uint32_t row = y0; row < y1; row += kRows)
      for (uint32_t column = x0; column < x1; column += kColumns) {
        Ray rays[kBatchLanes];
        RayInterval inside[kBatchLanes];
        WalkedRay walked[kBatchLanes];
        bool isAny = false;
        for (uint32_t lane = 0; lane < kBatchLanes; ++lane) {
          const uint32_t x = column + lane % kColumns, y = row + lane / kColumns;
          if (x >= x1 || y >= y1) continue;
          const RayInside ray = rayAt(x, y);
          rays[lane] = ray.ray, inside[lane] = ray.inside;
          isAny = isAny || !ray.inside.isMiss();
        }
        if (isAny) exceptionsExpected([&] { walk(rays, inside, walked); });
        for (uint32_t lane = 0; lane < kBatchLanes; ++lane)
          if (const uint32_t x = column + lane % kColumns, y = row + lane / kColumns; x < x1 && y < y1) take(x, y, walked[lane]);
      }
  });
}

}  // namespace warpscope
