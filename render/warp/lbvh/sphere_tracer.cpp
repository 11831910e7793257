// The tracers that need nothing but this program.
// See sphere_tracer.h.
#include "render/warp/lbvh/sphere_tracer.h"

#include "render/core/parallel.h"
#include "render/warp/lbvh/packet_trace.h"

namespace warpscope {

void LbvhTracer::build(std::span<const Sphere> spheres) { lbvh_.build(spheres); }

void LbvhTracer::build(std::span<const Sphere> spheres, std::span<const glm::vec3> halfLines) { lbvh_.build(spheres, halfLines); }

void LbvhTracer::trace(const Camera& camera, Image<uint32_t>& ids, Image<float>* depth,
                       const std::stop_token& stop) const {
  tracePackets(lbvh_.view(), camera, ids, depth, stop, arithmetic_);
}

void BruteForceTracer::build(std::span<const Sphere> spheres) {
  spheres_.clear();
  validateSpheres(spheres);
  spheres_.assign(spheres.begin(), spheres.end());
}

void BruteForceTracer::trace(const Camera& camera, Image<uint32_t>& ids, Image<float>* depth,
                             const std::stop_token& stop) const {
  ids.resize(camera.width, camera.height, kNoSample);
  if (depth) depth->resize(camera.width, camera.height, kNoHit);
  parallelForTiles(camera.width, camera.height, 8, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    for (uint32_t y = y0; y < y1; ++y) {
      for (uint32_t x = x0; x < x1; ++x) {
        const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
        float nearest = kNoHit;
        for (uint32_t id = 0; id < spheres_.size(); ++id) {
          const float t = intersectSphere(ray, spheres_[id].center, spheres_[id].radius);
          if (t >= nearest) continue;
          nearest = t;
          ids(x, y) = id;
        }
        if (depth) (*depth)(x, y) = nearest;
      }
    }
  });
}

}  // namespace warpscope
