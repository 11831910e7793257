// A walk for each pixel that notes what it goes through.
// See segment_look.h.
#include "render/warp/segments/segment_look.h"

#include <limits>

#include "render/march/march_setup.h"
#include "render/warp/segments/pixel_rays.h"
#include "render/warp/segments/segment_field_build.h"

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
  const float stopBelow = limitsOf(frame.settings.render).stopBelow;
  SegmentLook look;
  look.count.resize(camera.width, camera.height);
  look.depth.resize(camera.width, camera.height);
  forEachPixelRay<NotingRay>(
      frame, camera, stop,
      [&](const Ray& ray, const RayInterval& inside) {
        NotingRay walked;
        walkThrough<Between::nearest>(field, ray, inside.tNear, inside.tFar, stopBelow, walked);
        return walked;
      },
      [&](uint32_t x, uint32_t y, const Ray& ray, const NotingRay& noted) {
        look.count(x, y) = static_cast<float>(noted.count);
        look.depth(x, y) = noted.seen > 0.0f ? glm::length(ray.origin - camera.eye + ray.direction * (noted.places / noted.seen)) : std::numeric_limits<float>::quiet_NaN();
      });
  return look;
}

}  // namespace warpscope
