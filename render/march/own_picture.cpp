// Rays back in their pixels.
// See own_picture.h. Colours over one another: Porter, Duff 1984.
#include "render/march/own_picture.h"

#include "render/core/parallel.h"

namespace warpscope {

Image<uint32_t> ownPicture(const SampleFrame& frame) {
  const std::span<const uint8_t> layers = frame.layers();
  Image<uint32_t> pixels(frame.camera.width, frame.camera.height, kNoSample);
  for (size_t first = 0; first < frame.size(); first = endOfRay(layers, first)) {
    const uint32_t x = columnOf(frame.samples[first]), y = rowOf(frame.samples[first]);
    if (x >= pixels.width() || y >= pixels.height()) continue;
    uint32_t& seen = pixels(x, y);
    if (seen == kNoSample || depthCode(frame.samples[first]) < depthCode(frame.samples[seen])) seen = static_cast<uint32_t>(first);
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
