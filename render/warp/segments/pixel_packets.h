// The rays of a camera's pixels side by side, as many as a vector has lanes. On the host, on all cores.
// See pixel_rays.h.
#pragma once

#include <stop_token>

#include "render/core/crew.h"
#include "render/warp/segments/pixel_rays.h"
#include "render/warp/segments/ray_packet.h"

namespace warpscope {

/// As forEachPixelRay(), of pixels beside and above each other, whose rays' ways are alike. Calls `walk(rays, walked)`, where rays that are no pixel's are misses; and
/// `take(x, y, walked)` for each pixel. Throws OperationCancelled if `stop` is set.
template <class Walk, class Take>
void forEachPixelPacket(const SampleFrame& frame, const Camera& camera, const std::stop_token& stop, const Walk& walk, const Take& take) {
  constexpr uint32_t kColumns = RayPacket::kColumns, kRows = RayPacket::kRows;
  static_assert(kRayTileSide % kColumns == 0 && kRayTileSide % kRows == 0);
  const PixelRays pixels(frame, camera);
  parallelForTiles(camera.width, camera.height, kRayTileSide, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    RayPacket rays;
    for (uint32_t row = y0; row < y1; row += kRows)
      for (uint32_t column = x0; column < x1; column += kColumns) {
        Crew::pauseForBreaks();  // where much lies in their way, a tile's rays take some milliseconds
        WalkedRay walked[kBatchLanes];
        exceptionsExpected([&] {
          if (rays.set(pixels.pixels, pixels.bounds, column, row, x1, y1)) walk(rays, walked);
        });
        for (uint32_t lane = 0; lane < kBatchLanes; ++lane)
          if (const uint32_t x = column + lane % kColumns, y = row + lane / kColumns; x < x1 && y < y1) take(x, y, walked[lane]);
      }
  });
}

}  // namespace warpscope
