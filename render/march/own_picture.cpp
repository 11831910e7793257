// Rays back in their pixels.
// See own_picture.h. Colours over one another: Porter, Duff 1984.
#include "render/march/own_picture.h"

#include <limits>

#include "render/core/parallel.h"

namespace warpscope {

Image<uint32_t> ownPicture(const SampleFrame& frame) {
  const Camera& camera = frame.camera;
  const std::span<const uint8_t> layers = frame.layers();
  Image<uint32_t> pixels(camera.width, camera.height, kNoSample);
  Image<float> depths(camera.width, camera.height, std::numeric_limits<float>::infinity());
  for (size_t first = 0, end = 0; first < frame.size(); first = end) {
    end = endOfRay(layers, first);
    const Projection nearest = project(camera, frame.sphere(first).center);
    const Projection farthest = end - first == 1 ? nearest : project(camera, frame.sphere(end - 1).center);
    if (!(nearest.forwardDepth > 0.0f) || !(farthest.forwardDepth > 0.0f)) continue;
    if (!(farthest.pixel.x >= 0.0f) || !(farthest.pixel.y >= 0.0f)) continue;
    if (farthest.pixel.x >= static_cast<float>(camera.width) || farthest.pixel.y >= static_cast<float>(camera.height)) continue;
    const auto x = static_cast<uint32_t>(farthest.pixel.x), y = static_cast<uint32_t>(farthest.pixel.y);
    if (!(nearest.forwardDepth < depths(x, y))) continue;
    depths(x, y) = nearest.forwardDepth;
    pixels(x, y) = static_cast<uint32_t>(first);
  }
  return pixels;
}

void resolveRayColors(const SampleFrame& frame, const Image<uint32_t>& rays, Image<glm::vec4>& color) {
  color.reshape(rays.width(), rays.height());
  const ColorTables& tables = ColorTables::instance();
  const std::span<const uint8_t> layers = frame.layers();
  parallelForRanges(rays.size(), 1 << 15, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      glm::vec4 sum(0.0f);
      if (rays[i] < frame.size()) {
        sum = tables.decode(frame.colors[rays[i]]);
        for (size_t sample = rays[i] + 1, past = endOfRay(layers, rays[i]); sample < past; ++sample)
          sum = over(sum, tables.decode(frame.colors[sample]));
      }
      color[i] = sum;
    }
  });
}

}  // namespace warpscope
