// Row by row.
// See displayed.h.
#include "render/metrics/displayed.h"

#include <atomic>
#include <cmath>
#include <string>

#include "render/core/color.h"
#include "render/core/error.h"
#include "render/core/parallel.h"

namespace warpscope {

DisplayedPlanes displayedPlanes(const Image<glm::vec4>& image, const glm::vec3& background, std::string_view metric) {
  DisplayedPlanes planes;
  for (Image<float>& plane : planes) plane.reshape(image.width(), image.height());
  std::atomic<bool> isFinite = true;
  parallelForRanges(image.size(), 1 << 14, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const glm::vec4& pixel = image[i];
      // One sum is enough: it is not finite if a part of it is not.
      if (!std::isfinite(pixel.r + pixel.g + pixel.b + pixel.a)) isFinite = false;
      const glm::vec4 color = over(pixel, {background, 1.0f});
      for (int channel = 0; channel < 3; ++channel)
        planes[static_cast<size_t>(channel)][i] = srgbFromLinear(glm::clamp(color[channel], 0.0f, 1.0f));
    }
  });
  if (!isFinite) throw InputError(std::string(metric) + ": a pixel is not finite");
  return planes;
}

void requireOneSize(const Image<glm::vec4>& a, const Image<glm::vec4>& b, std::string_view metric) {
  if (a.width() != b.width() || a.height() != b.height() || a.empty())
    throw InputError(std::string(metric) + " needs two images of one size");
}

}  // namespace warpscope
