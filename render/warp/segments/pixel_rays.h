// The rays of a camera's pixels through what a frame's segments are of. On the host, on all cores.
#pragma once

#include <stop_token>

#include "render/base/error.h"
#include "render/core/crew.h"
#include "render/core/floating_point.h"
#include "render/core/parallel.h"
#include "render/march/sample_frame.h"
#include "render/warp/segments/segment_walk.h"

namespace warpscope {

/// A ray, and its part inside a frame's bounds.
struct RayInside {
  Ray ray;
  RayInterval inside;  ///< a miss if there is none
};

/// Those of a camera's pixels through a frame's bounds.
struct PixelRays {
  Box bounds;
  PixelGrid pixels;

  PixelRays(const SampleFrame& frame, const Camera& camera)
      : bounds(frame.quantization.bounds), pixels(makePixelGrid(camera, depthRangeOf(camera, frame.quantization.bounds).nearDepth)) {}
  RayInside at(uint32_t x, uint32_t y) const {
    const Ray ray = pixels.ray(x, y).ray;
    return {ray, exceptionsExpected([&] { return partInside(bounds, ray); })};
  }
};

/// Edge of the tiles in which pixels' rays are walked.
inline constexpr uint32_t kRayTileSide = 16;

/// Calls `take(x, y, ray, walked)` for every pixel. `walked` is a `Walked`, made by `walk(ray, inside)` of the ray's part inside the frame's bounds; as it begins where
/// there is none. Throws OperationCancelled if `stop` is set.
template <class Walked, class Walk, class Take>
void forEachPixelRay(const SampleFrame& frame, const Camera& camera, const std::stop_token& stop, const Walk& walk, const Take& take) {
  const PixelRays rays(frame, camera);
  parallelForTiles(camera.width, camera.height, kRayTileSide, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    for (uint32_t y = y0; y < y1; ++y) {
      Crew::pauseForBreaks();  // where much lies in their way, a tile's rays take some milliseconds
      for (uint32_t x = x0; x < x1; ++x) {
        const RayInside ray = rays.at(x, y);
        const Walked walked = ray.inside.isMiss() ? Walked{} : exceptionsExpected([&] { return walk(ray.ray, ray.inside); });
        take(x, y, ray.ray, walked);
      }
    }
  });
}

}  // namespace warpscope
