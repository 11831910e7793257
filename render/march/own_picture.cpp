// Samples back in their pixels.
// See own_picture.h.
#include "render/march/own_picture.h"

#include <limits>

namespace warpscope {

Image<uint32_t> ownPicture(const SampleFrame& frame) {
  const Camera& camera = frame.camera;
  Image<uint32_t> pixels(camera.width, camera.height, kNoSample);
  Image<float> depths(camera.width, camera.height, std::numeric_limits<float>::infinity());
  for (size_t i = 0; i < frame.size(); ++i) {
    const Projection seen = project(camera, frame.sphere(i).center);
    if (!(seen.forwardDepth > 0.0f) || !(seen.pixel.x >= 0.0f) || !(seen.pixel.y >= 0.0f)) continue;
    if (seen.pixel.x >= camera.width || seen.pixel.y >= camera.height) continue;
    const auto x = static_cast<uint32_t>(seen.pixel.x), y = static_cast<uint32_t>(seen.pixel.y);
    if (!(seen.forwardDepth < depths(x, y))) continue;
    depths(x, y) = seen.forwardDepth;
    pixels(x, y) = static_cast<uint32_t>(i);
  }
  return pixels;
}

}  // namespace warpscope
