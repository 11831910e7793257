// Mean squared error in parallel, summed in double.
// See psnr.h.
#include "render/metrics/psnr.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <cmath>
#include <limits>

#include "render/core/color.h"
#include "render/core/error.h"

namespace warpscope {
namespace {

bool isFinite(const glm::vec4& v) {
  return std::isfinite(v.r) && std::isfinite(v.g) && std::isfinite(v.b) && std::isfinite(v.a);
}

glm::vec3 displayed(const glm::vec4& premultiplied, const glm::vec3& background) {
  const glm::vec4 color = over(premultiplied, {background, 1.0f});
  const auto encode = [](float v) { return srgbFromLinear(glm::clamp(v, 0.0f, 1.0f)); };
  return {encode(color.r), encode(color.g), encode(color.b)};
}

}  // namespace

double psnrSrgb(const Image<glm::vec4>& image, const Image<glm::vec4>& reference, const glm::vec3& background) {
  if (image.width() != reference.width() || image.height() != reference.height() || image.empty())
    throw InputError("PSNR needs two images of one size");
  // Fixed pieces, summed in order: the same number whatever the number of threads.
  constexpr size_t kPiece = 1 << 14;
  const auto sum = tbb::parallel_deterministic_reduce(
      tbb::blocked_range<size_t>(0, image.size(), kPiece), 0.0,
      [&](const tbb::blocked_range<size_t>& range, double partial) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
          if (!isFinite(image[i]) || !isFinite(reference[i])) return std::numeric_limits<double>::infinity();
          if (image[i] == reference[i]) continue;
          const glm::dvec3 difference(displayed(image[i], background) - displayed(reference[i], background));
          partial += glm::dot(difference, difference);
        }
        return partial;
      },
      std::plus<>());
  if (!std::isfinite(sum)) throw InputError("PSNR: a pixel is not finite");
  if (sum == 0.0) return std::numeric_limits<double>::infinity();
  return -10.0 * std::log10(sum / (3.0 * static_cast<double>(image.size())));
}

}  // namespace warpscope
