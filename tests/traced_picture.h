// What a sphere tracer says of every pixel, as one value: tests of tracers compare these.
#pragma once

#include <span>

#include "render/warp/lbvh/sphere_tracer.h"

namespace warpscope {

struct TracedPicture {
  Image<uint32_t> ids;
  Image<float> depth;
};

/// Builds a tracer over the cloud and has it look through the camera.
template <class Tracer>
TracedPicture tracedPicture(std::span<const Sphere> cloud, const Camera& camera) {
  Tracer tracer;
  tracer.build(cloud);
  TracedPicture result;
  tracer.trace(camera, result.ids, &result.depth, {});
  return result;
}

}  // namespace warpscope
