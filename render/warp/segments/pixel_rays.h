// The rays of a camera's pixels through what a frame's segments are of. On the host, on all cores.
#pragma once

#include <stop_token>

#include "render/core/floating_point.h"
#include "render/core/parallel.h"
#include "render/march/sample_frame.h"
#include "render/warp/segments/segment_walk.h"

namespace warpscope {

/// Calls `take(x, y, ray, walked)` for every pixel. `walked` is a `Walked`, made by `walk(ray, inside)` of the ray's part inside the frame's bounds; as it begins where
/// there is none. Throws OperationCancelled if `stop` is set.
template <class Walked, class Walk, class Take>
void forEachPixelRay(const SampleFrame& frame, const Camera& camera, const std::stop_token& stop, const Walk& walk, const Take& take) {
  constexpr uint32_t kTileSide = 32;
  const Box& bounds = frame.quantization.bounds;
  const PixelGrid pixels = makePixelGrid(camera, depthRangeOf(camera, bounds).nearDepth);
  parallelForTiles(camera.width, camera.height, kTileSide, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    for (uint32_t y = y0; y < y1; ++y)
      for (uint32_t x = x0; x < x1; ++x) {
        const Ray ray = pixels.ray(x, y).ray;
        const Walked walked = exceptionsExpected([&] {
          const RayInterval inside = partInside(bounds, ray);
          return inside.isMiss() ? Walked{} : walk(ray, inside);
        });
        take(x, y, ray, walked);
      }
  });
}

}  // namespace warpscope
