// A walk for each pixel that notes what it goes through.
// See segment_look.h.
#include "render/warp/segments/segment_look.h"

#include <limits>

#include "render/core/floating_point.h"
#include "render/core/parallel.h"
#include "render/march/march_setup.h"
#include "render/warp/segments/segment_field_build.h"
#include "render/warp/segments/segment_walk.h"

namespace warpscope {
namespace {

struct NotingRay : WalkedRay {
  static constexpr uint32_t kNone = 0xffffffffu;
  uint32_t last = kNone;  // segment
  uint32_t count = 0;
  float seen = 0.0f, places = 0.0f;  // opacity, and times the distance along the ray

  void meet(uint32_t segment, float t, float opacity) {
    if (segment != last) ++count;
    last = segment;
    seen += through * opacity;
    places += through * opacity * t;
  }
};

}  // namespace

SegmentLook lookAtSegments(const SampleFrame& frame, const Camera& camera, const std::stop_token& stop) {
  requireUsable(camera);
  BuiltSegmentField built;
  built.build(frame);
  const SegmentField field = built.field();
  const Box& bounds = frame.quantization.bounds;
  const PixelGrid pixels = makePixelGrid(camera, depthRangeOf(camera, bounds).nearDepth);
  const float stopBelow = limitsOf(frame.settings.render).stopBelow;
  SegmentLook look;
  look.count.resize(camera.width, camera.height);
  look.depth.resize(camera.width, camera.height);
  constexpr uint32_t kTileSide = 32;
  parallelForTiles(camera.width, camera.height, kTileSide, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    for (uint32_t y = y0; y < y1; ++y)
      for (uint32_t x = x0; x < x1; ++x) {
        const Ray ray = pixels.ray(x, y).ray;
        const NotingRay noted = exceptionsExpected([&] {
          const RayInterval inside = partInside(bounds, ray);
          NotingRay walked;
          if (!inside.isMiss()) walkThrough<false>(field, ray, inside.tNear, inside.tFar, stopBelow, walked);
          return walked;
        });
        look.count(x, y) = static_cast<float>(noted.count);
        look.depth(x, y) = noted.seen > 0.0f ? glm::length(ray.origin - camera.eye + ray.direction * (noted.places / noted.seen)) : std::numeric_limits<float>::quiet_NaN();
      }
  });
  return look;
}

}  // namespace warpscope
